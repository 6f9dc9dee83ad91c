"""The expected delta chi-square by which a planned experiment distinguishes two fitted models.

    dchi2 = min_p  |d + J p|^2 + |K p|^2, d = (prediction of the assumed truth - prediction of the rival) over the noise

The rival may refit all its parameters p: J are its derivatives in the new experiment, K those in the fitted runs and
priors. At the rival's fit chi-square of the latter is at its minimum, so no linear term remains.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from motofmi.gap.estimation.fit_result import Fit, run_to_run_deviations
from motofmi.gap.models.any_model import AnyRun


@dataclass(frozen=True)
class Prediction:
    """What a fitted model predicts for a planned run: data (m,) over the noise, and derivatives (m,
    common parameters + more).

    The further columns are by parameters of the new run alone, whose priors are the last rows.
    """

    predicted: np.ndarray
    slopes: np.ndarray


def predict_run(found: Fit, run: AnyRun) -> Prediction:
    """The prediction of a fit for a planned run, with priors on the base's deviation from run to run."""
    deviations = run_to_run_deviations(found.model.experiment)
    predicted, own = found.model.reduced(run, found.shared)
    spreads = np.diag([1 / deviation for deviation in deviations.values()])
    priors = np.hstack([np.zeros((len(deviations), len(found.model.names))), spreads])
    return Prediction(
        np.concatenate([predicted, np.zeros(len(deviations))]),
        np.vstack([np.hstack([own, own[:, list(deviations)]]), priors]),
    )


def separation(rival: Fit, difference: np.ndarray, slopes: np.ndarray) -> float:
    """The least increase of a rival's chi-square, where new data differ by (m,) from its prediction
    with derivatives (m, ...).

    The parameters of effects stay within their bounds, which include the physical sign.
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
