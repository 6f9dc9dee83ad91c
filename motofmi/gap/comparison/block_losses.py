r"""The loss of a fitted model per block of its residuals.

    l_b = log(mean r_b^2 + floor)

Blocks are longer than the correlation of the residuals, so that losses of blocks are nearly independent. The logarithm
limits the weight of a single block with a large misfit. On fitted runs a block's residual is that of the
fit without the block, to first order:

    r_(b) = r_b + J_b (J'J - J_b'J_b)^-1 J_b' r_b

On validation runs parameters are fixed as fitted, and residuals are used as they are.

Source: Cook, Weisberg, Residuals and Influence in Regression (1982), ch. 3 (deletion of a group of cases); Politis,
White, Econometric Reviews 23 (2004) 53-70 (correlation length).
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from motofmi.gap.comparison.normal_equations import NormalEquations, pseudo_inverse
from motofmi.gap.comparison.residuals import Block, TimeResiduals

MOST_BLOCKS = 60  # blocks of all runs together; the effort of a comparison grows with them
SHORTEST_BLOCK = 8  # samples
SIGNIFICANT = 2.0  # significant autocorrelation [1] over sqrt(log10(n) / n), as Politis and White recommend
LEAST_LAGS = 5  # consecutive insignificant lags that end the correlation: max(5, sqrt(log10(n))), same source


def correlation_length(residuals: np.ndarray) -> int:
    """The lag in samples from which the autocorrelation of residuals (n,) is insignificant (Politis, White 2004)."""
    x = residuals - residuals.mean()
    n = len(x)
    power = np.abs(np.fft.rfft(x, 2 * n)) ** 2
    correlation = np.fft.irfft(power)[:n]
    if correlation[0] <= 0:
        return 1
    small = np.abs(correlation / correlation[0]) < SIGNIFICANT * np.sqrt(np.log10(n) / n)
    needed = max(LEAST_LAGS, int(np.ceil(np.sqrt(np.log10(n)))))
    consecutive = np.convolve(small, np.ones(needed), "valid")
    return int(np.argmax(consecutive >= needed)) if np.any(consecutive >= needed) else n


def partition(residuals: TimeResiduals, length: int | None = None) -> list[Block]:
    """Blocks of at least `length` samples in every run, or one block per run where the run is shorter.

    By default the blocks are as long as the correlation of the residuals.
    """
    if length is None:
        correlated = max(correlation_length(run[:, k]) for run in residuals.runs for k in range(run.shape[1]))
        length = max(correlated, sum(residuals.lengths) // MOST_BLOCKS, SHORTEST_BLOCK)
    blocks: list[Block] = []
    for index, n in enumerate(residuals.lengths):
        edges = np.linspace(0, n, max(n // length, 1) + 1).astype(int)
        blocks += [(index, int(a), int(b)) for a, b in pairwise(edges)]
    return blocks


def divided(blocks: Sequence[Block], least: int) -> list[Block]:
    """The blocks, in equal parts where there are fewer than `least`."""
    parts = -(-least // len(blocks))
    return [
        (i, int(first), int(last))
        for i, a, b in blocks
        for first, last in pairwise(np.linspace(a, b, parts + 1).astype(int))
    ]


def standard_error(differences: np.ndarray) -> float:
    """The standard error of the mean of differences (blocks,) between blocks; infinite of a single one."""
    return float(differences.std(ddof=1) / np.sqrt(len(differences))) if len(differences) > 1 else np.inf


def mean_squares(residuals: TimeResiduals, blocks: Sequence[Block]) -> np.ndarray:
    """The mean square (blocks,) of the residuals of each block [1]."""
    return np.array([np.mean(residuals.runs[i][a:b] ** 2) for i, a, b in blocks])


def left_out_mean_squares(residuals: TimeResiduals, blocks: Sequence[Block]) -> np.ndarray:
    """The mean square (blocks,) of each block's residuals in the fit without that block [1]."""
    normal = NormalEquations(residuals)
    squares = []
    for slopes, left in map(normal.of_block, blocks):
        others = pseudo_inverse(normal.matrix - slopes.T @ slopes)
        squares.append(float(np.mean((left + slopes @ (others @ (slopes.T @ left))) ** 2)))
    return np.array(squares)
