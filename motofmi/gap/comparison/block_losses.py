r"""The loss of a fitted model per block of its residuals.

    l_b = log(mean r_b^2 + floor)

Blocks are longer than the correlation of the residuals, so that losses of blocks are nearly independent. The logarithm
keeps a single block with a large misfit from deciding a comparison. On fitted runs a block's residual is that of the
fit without the block, to first order:

    r_(b) = r_b + J_b (J'J - J_b'J_b)^-1 J_b' r_b

On validation runs parameters are fixed as fitted, and residuals are used as they are.

Source: Cook, Weisberg, Residuals and Influence in Regression (1982), ch. 3 (deletion of a group of cases); Politis,
White, Econometric Reviews 23 (2004) 53-70 (correlation length).
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from motofmi.gap.comparison.residuals import TimeResiduals

Block = tuple[int, int, int]  # run, first sample, last sample + 1
MOST = 60  # blocks of all runs: more take time and add nothing to a comparison
SIGNIFICANT = 2.0  # of the correlation, in units of sqrt(log10(n) / n): Politis and White's constant
LEAST = 1e-12  # of the largest derivative: a parameter below it has no influence on the output
RANK = 1e-9  # relative eigenvalue of J'J below which a direction is not determined by the other blocks


def correlation_length(residuals: np.ndarray) -> int:
    """The lag in samples from which the autocorrelation of residuals (n,) is insignificant (Politis, White 2004)."""
    x = residuals - residuals.mean()
    n = len(x)
    power = np.abs(np.fft.rfft(x, 2 * n)) ** 2
    correlation = np.fft.irfft(power)[:n]
    if correlation[0] <= 0:
        return 1
    small = np.abs(correlation / correlation[0]) < SIGNIFICANT * np.sqrt(np.log10(n) / n)
    needed = max(5, int(np.ceil(np.sqrt(np.log10(n)))))
    consecutive = np.convolve(small, np.ones(needed), "valid")
    return int(np.argmax(consecutive >= needed)) if np.any(consecutive >= needed) else n


def partition(residuals: TimeResiduals) -> list[Block]:
    """Blocks of equal length in every run, as long as the correlation of these residuals."""
    correlated = max(correlation_length(run[:, k]) for run in residuals.runs for k in range(run.shape[1]))
    length = max(correlated, sum(residuals.lengths) // MOST, 8)
    blocks: list[Block] = []
    for index, n in enumerate(residuals.lengths):
        edges = np.linspace(0, n, max(n // length, 1) + 1).astype(int)
        blocks += [(index, int(a), int(b)) for a, b in pairwise(edges)]
    return blocks


def mean_squares(residuals: TimeResiduals, blocks: Sequence[Block]) -> np.ndarray:
    """The mean square (blocks,) of the residuals as they are."""
    return np.array([np.mean(residuals.runs[i][a:b] ** 2) for i, a, b in blocks])


def left_out_mean_squares(residuals: TimeResiduals, blocks: Sequence[Block]) -> np.ndarray:
    """The mean square (blocks,) of each block's residuals in the fit without that block."""
    count = residuals.priors.shape[1]
    slopes = [run.reshape(-1, count) for run in residuals.slopes]
    normal = sum(s.T @ s for s in slopes) + residuals.priors.T @ residuals.priors
    scale = np.sqrt(np.diag(normal))
    scale[scale < LEAST * scale.max()] = np.inf  # a parameter without influence
    normal = normal / np.outer(scale, scale)
    squares = []
    for i, a, b in blocks:
        outputs = residuals.runs[i].shape[1]
        part, left = slopes[i][a * outputs : b * outputs] / scale, residuals.runs[i][a:b].ravel()
        others = np.linalg.pinv(normal - part.T @ part, rcond=RANK, hermitian=True)
        squares.append(float(np.mean((left + part @ (others @ (part.T @ left))) ** 2)))
    return np.array(squares)
