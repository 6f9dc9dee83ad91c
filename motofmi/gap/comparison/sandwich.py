r"""The covariance of fitted values where the model is incomplete: the sandwich estimator over blocks.

    V = H^-1 (sum_b g_b g_b' B / (B - 1) + P'P) H^-1,   H = J'J + P'P,   g_b = J_b' r_b

P are the derivatives of the prior terms, which are independent with variance 1, and B is the number of blocks.

The usual covariance H^-1 holds where residuals are independent noise. The residuals of an incomplete model are
correlated over time and with the derivatives. Sums over blocks longer than the correlation include both correlations.

Source: Huber, Proc. Fifth Berkeley Symp. 1 (1967) 221-233; White, Econometrica 48 (1980) 817-838; clustered form of
Liang, Zeger, Biometrika 73 (1986) 13-22.
"""

from collections.abc import Sequence

import numpy as np

from motofmi.gap.comparison.normal_equations import NormalEquations
from motofmi.gap.comparison.residuals import Block, TimeResiduals


def sandwich_covariance(residuals: TimeResiduals, blocks: Sequence[Block]) -> np.ndarray:
    """The covariance (parameters, parameters) of the fitted values, in the products of their units."""
    normal = NormalEquations(residuals)
    gradients = np.array([slopes.T @ left for slopes, left in map(normal.of_block, blocks)])
    middle = gradients.T @ gradients * len(blocks) / max(len(blocks) - 1, 1) + normal.priors.T @ normal.priors
    return normal.inverse @ middle @ normal.inverse / np.outer(normal.scale, normal.scale)
