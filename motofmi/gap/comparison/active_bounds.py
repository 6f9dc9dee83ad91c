r"""Parameters of the base that a fit moved to zero, where a bound allows no other sign.

    step = -J^+ r,   parameter (1 + step) < 0

J are the derivatives of the residuals r by the logarithms of the parameters. A fit of logarithms moves a mass or a
damper that the data do not show towards zero, and never reaches it. Where a Gauss-Newton step in the parameter itself
would make it negative, its bound is active, and the errors of all others are those with this parameter fixed. In a
slow test at one speed, a negative damper could take the place of friction of any magnitude.

Source: Stoica, Ng, IEEE Signal Process. Lett. 5 (1998) 177-179 (errors under constraints); Nocedal, Wright, Numerical
Optimization, 2nd ed. (2006), section 16.5 (active sets).
"""

import numpy as np

from motofmi.gap.estimation.fit_result import Fit

RANK = 1e-9  # relative singular value below which the data do not determine a direction


def at_zero(found: Fit) -> np.ndarray:
    """The places in x of the base's parameters whose bound at zero is active."""
    table, base = found.model.component.table, found.model.base
    bounded = np.array([table[name].min >= 0 or table[name].max <= 0 for name in base], bool)
    scale = np.linalg.norm(found.jacobian, axis=0)
    scale[scale == 0] = np.inf
    step = -np.linalg.lstsq(found.jacobian / scale, found.residuals, rcond=RANK)[0] / scale
    return np.flatnonzero(bounded & (step[: len(base)] < -1))
