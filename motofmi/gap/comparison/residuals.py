"""The residuals of a fit over time, within the compared band, and their derivatives by the fitted parameters.

A fit compares cosine coefficients of blocks (see `preprocessing.blocks`). Their inverse transform is the residual over
time, of which initial states and offsets are eliminated already. Every output is divided by its mean standard
deviation, so that outputs of different units are compared with equal weight.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import idct

from motofmi.gap.estimation.fit_result import Fit


@dataclass(frozen=True)
class TimeResiduals:
    """Residuals of every run (n, outputs) and their derivatives (n, outputs, parameters), and the units of the
    outputs (outputs,): the standard deviations by which they are divided.

    priors (k, parameters) are the derivatives of the prior terms of the fit in the same weights.
    """

    runs: list[np.ndarray]
    slopes: list[np.ndarray]
    scale: np.ndarray
    priors: np.ndarray

    @property
    def lengths(self) -> list[int]:
        """The samples of every run."""
        return [len(run) for run in self.runs]


def time_residuals(found: Fit, scale: np.ndarray | None = None) -> TimeResiduals:
    """The residuals of a fit over time. scale (outputs,) are the units of the outputs; by default those of the fit.

    Raises ValueError where residuals or derivatives are not finite.
    """
    if not (np.all(np.isfinite(found.residuals)) and np.all(np.isfinite(found.jacobian))):
        raise ValueError(f"{found!r}: residuals or derivatives that are not finite")
    scale = output_scale(found) if scale is None else scale
    residuals, slopes, first = [], [], 0
    for run in found.runs:
        last = first + len(run.data)
        left = (found.residuals[first:last] * run.deviation)[:, None]
        both = _over_time(run, np.hstack([left, found.jacobian[first:last] * run.deviation[:, None]])) / scale[:, None]
        residuals.append(both[:, :, 0])
        slopes.append(both[:, :, 1:])
        first = last
    return TimeResiduals(residuals, slopes, scale, found.jacobian[first:])


def output_scale(found: Fit) -> np.ndarray:
    """The root mean square (outputs,) of the standard deviations of each output's data, over all runs."""
    outputs = found.runs[0].reduction.outputs
    power = np.zeros(outputs)
    for run in found.runs:
        owners = np.array([column.degree for column in run.reduction.columns])
        power += [float(np.mean(run.deviation[owners == output] ** 2)) for output in range(outputs)]
    return np.sqrt(power / len(found.runs))


def _over_time(run, columns: np.ndarray) -> np.ndarray:
    """Coefficients (m, k) as samples (n, outputs, k) of all blocks, one after another."""
    parts, at, outputs = [], 0, run.reduction.outputs
    for first, last, kept in run.reduction.spans:
        block = np.zeros((last - first, outputs, columns.shape[1]))
        for output in range(outputs):
            block[:kept, output] = columns[at : at + kept]
            at += kept
        parts.append(idct(block, axis=0, norm="ortho"))
    return np.concatenate(parts)
