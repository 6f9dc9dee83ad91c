r"""By how much fitted values depend on the band of frequencies that is compared.

    q_l - q = N_l^-1 sum_b (g_b - g_lb),   g_b = J_b' r_b
    var(q_l - q) = sum_b d_b^2 B / (B - 1),   d_b = N^-1 g_b - N_l^-1 g_lb

q are the values of a fit over the whole band and q_l those over its lowest part, to first order. N is the normal
matrix, J_b and r_b are the derivatives and residuals of one of B blocks; the index l denotes the lowest part. A right
model has the same values in both, within the standard error of the difference; a larger difference is an error of the
model, which no resampling over blocks includes.

Source: Hausman, Econometrica 46 (1978) 1251-1271 (contrast of two estimators of the same values).
"""

from collections.abc import Sequence

import numpy as np

from motofmi.gap.comparison.normal_equations import NormalEquations
from motofmi.gap.comparison.residuals import Block, TimeResiduals

LOWEST_PART = 0.25  # of the compared band


def band_dependence(whole: TimeResiduals, low: TimeResiduals, blocks: Sequence[Block], errors: float) -> np.ndarray:
    """The differences (parameters,) between values of the lowest part of the band and those of the whole band.

    whole and low are the residuals of the same fit over the whole band and over its lowest part. A difference that is
    less than `errors` times its standard error is returned as zero.
    """
    of_whole, of_low = NormalEquations(whole), NormalEquations(low)
    gradients, in_low = (
        np.array([slopes.T @ left * _finite(normal.scale) for slopes, left in map(normal.of_block, blocks)])
        for normal in (of_whole, of_low)
    )
    covariance, of_part = (normal.inverse / np.outer(normal.scale, normal.scale) for normal in (of_whole, of_low))
    change = of_part @ (gradients - in_low).sum(axis=0)
    influence = gradients @ covariance - in_low @ of_part
    deviation = np.sqrt(np.sum(influence**2, axis=0) * len(blocks) / max(len(blocks) - 1, 1))
    return np.where(np.abs(change) > errors * deviation, change, 0.0)


def _finite(scale: np.ndarray) -> np.ndarray:
    """The scale of parameters that have an influence, zero for the others."""
    return np.where(np.isfinite(scale), scale, 0.0)
