"""By how much a test that has not been made would tell two fitted models apart.

    dchi2 = min_p  |d + J p|^2 + |K p|^2,   d = (what the truth would give - what the rival gives) over the noise

The rival may refit all its parameters p, as far as what it was fitted to lets it: J are its slopes in the new test, K
those in the tests and priors so far. At the rival's fit these are at their least, so that no linear term remains.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from identification.gap.models.model import AnyRun
from identification.gap.naming.fitted import Fit, deviating


@dataclass(frozen=True)
class Foresight:
    """What a fitted model foresees of a test: data (m,) over the noise, and slopes (m, common parameters + more).

    The further columns are by parameters of the new test alone, whose priors are rows at the end.
    """

    predicted: np.ndarray
    slopes: np.ndarray


def through(found: Fit, run: AnyRun) -> Foresight:
    """What a fit foresees of a planned run: the base deviates there as it does from run to run."""
    moved = deviating(found.model.stand)
    predicted, own = found.model.reduced(run, found.shared)
    spreads = np.diag([1 / deviation for deviation in moved.values()])
    priors = np.hstack([np.zeros((len(moved), len(found.model.names))), spreads])
    return Foresight(np.concatenate([predicted, np.zeros(len(moved))]), np.vstack([np.hstack([own, own[:, list(moved)]]), priors]))


def separation(rival: Fit, difference: np.ndarray, slopes: np.ndarray) -> float:
    """The least of chi-square that a rival comes to, where new data differ by (m,) from what it foresees with slopes (m, ...).

    The parameters of effects stay within their bounds, which hold the physical sign.
    """
    shared, known = len(rival.model.names), rival.jacobian.shape[1]
    new = slopes.shape[1] - shared
    matrix = np.zeros((len(difference) + len(rival.jacobian), known + new))
    matrix[: len(difference), :shared] = slopes[:, :shared]
    matrix[: len(difference), known:] = slopes[:, shared:]
    matrix[len(difference) :, :known] = rival.jacobian
    low, high = np.full(known + new, -np.inf), np.full(known + new, np.inf)
    nb = len(rival.model.base)
    low[nb:shared] = [row.min - x for row, x in zip(rival.model.rows, rival.x[nb:shared], strict=True)]
    high[nb:shared] = [row.max - x for row, x in zip(rival.model.rows, rival.x[nb:shared], strict=True)]
    scale = np.linalg.norm(matrix, axis=0) + 1e-12
    target = np.concatenate([-difference, np.zeros(len(rival.jacobian))])
    bounds = (np.minimum(low * scale, -1e-12), np.maximum(high * scale, 1e-12))
    return float(2 * lsq_linear(matrix / scale, target, bounds).cost)
