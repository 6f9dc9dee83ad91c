r"""The covariance of fitted values that includes what the model leaves: the sandwich over blocks.

    V = H^-1 (sum_b g_b g_b' B / (B - 1) + P'P) H^-1,   H = J'J + P'P,   g_b = J_b' r_b

P are the derivatives of the prior terms, which are independent with variance 1.

The usual covariance H^-1 holds where residuals are independent noise. Where a model is incomplete its residuals are
correlated over time and with the derivatives; sums over blocks longer than the correlation keep both.

Source: Huber, Proc. Fifth Berkeley Symp. 1 (1967) 221-233; White, Econometrica 48 (1980) 817-838; clustered form of
Liang, Zeger, Biometrika 73 (1986) 13-22.
"""

from collections.abc import Sequence

import numpy as np

from motofmi.gap.comparison.block_losses import LEAST, RANK, Block
from motofmi.gap.comparison.residuals import TimeResiduals


def sandwich_covariance(residuals: TimeResiduals, blocks: Sequence[Block]) -> np.ndarray:
    """The covariance (parameters, parameters) of the fitted values."""
    count = residuals.priors.shape[1]
    slopes = [run.reshape(-1, count) for run in residuals.slopes]
    normal = sum(s.T @ s for s in slopes) + residuals.priors.T @ residuals.priors
    scale = np.sqrt(np.diag(normal))
    scale[scale < LEAST * scale.max()] = np.inf  # a parameter without influence
    inverse = np.linalg.pinv(normal / np.outer(scale, scale), rcond=RANK, hermitian=True)
    gradients = []
    for i, a, b in blocks:
        outputs = residuals.runs[i].shape[1]
        gradients.append((slopes[i][a * outputs : b * outputs] / scale).T @ residuals.runs[i][a:b].ravel())
    middle = np.array(gradients).T @ np.array(gradients) * len(blocks) / max(len(blocks) - 1, 1)
    priors = residuals.priors / scale
    middle += priors.T @ priors
    return inverse @ middle @ inverse / np.outer(scale, scale)
