"""The residuals of a fit over time, within the compared band, and their derivatives by the fitted parameters.

A fit compares cosine coefficients of blocks (see `preprocessing.blocks`). Their inverse transform is the residual over
time, from which the effects of initial states and sensor offsets are already eliminated. Every output is divided by
the root mean square of its noise's standard deviations, so that outputs of different units have equal weight.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import idct

from motofmi.gap.estimation.fit_result import Fit

Block = tuple[int, int, int]  # run, first sample, last sample + 1


@dataclass(frozen=True)
class TimeResiduals:
    """Residuals (n, outputs) of every run, and their derivatives (n, outputs, parameters), over each output's scale.

    scale (outputs,) are the standard deviations by which the outputs are divided, in the unit of each output; priors
    (k, parameters) are the derivatives of the prior terms of the fit, which have standard deviation 1.
    """

    runs: list[np.ndarray]
    slopes: list[np.ndarray]
    scale: np.ndarray
    priors: np.ndarray

    def with_fixed(self, places: np.ndarray) -> "TimeResiduals":
        """The residuals where some parameters are not fitted."""
        slopes, priors = [run.copy() for run in self.slopes], self.priors.copy()
        for each in (*slopes, priors):
            each[..., places] = 0.0
        return replace(self, slopes=slopes, priors=priors)

    @property
    def lengths(self) -> list[int]:
        """The number of samples of every run."""
        return [len(run) for run in self.runs]


def time_residuals(found: Fit, scale: np.ndarray | None = None, part: float = 1.0) -> TimeResiduals:
    """The residuals of a fit over time, over scale (outputs,); by default that of the fit (see `output_scale`).

    part [1] is the share of the compared band, from its lower end, that the residuals contain. Raises ValueError where
    residuals or derivatives are not finite.
    """
    if not (np.all(np.isfinite(found.residuals)) and np.all(np.isfinite(found.jacobian))):
        raise ValueError(f"{found!r}: residuals or derivatives are not finite; expected a fit that can be simulated")
    scale = output_scale(found) if scale is None else scale
    residuals, slopes, first = [], [], 0
    for run in found.runs:
        last = first + len(run.data)
        frequency = np.array([column.frequency for column in run.reduction.columns])
        weight = np.where(frequency <= part * frequency.max(), run.deviation, 0.0)
        columns = np.column_stack([found.residuals[first:last], found.jacobian[first:last]]) * weight[:, None]
        over_time = _over_time(run, columns) / scale[:, None]
        residuals.append(over_time[:, :, 0])
        slopes.append(over_time[:, :, 1:])
        first = last
    return TimeResiduals(residuals, slopes, scale, found.jacobian[first:])


def whitened_residuals(found: Fit) -> list[np.ndarray]:
    """The residuals (n, outputs) of every run over time, whitened [1]: those of noise alone have a mean square of 1.

    Every coefficient is divided by the standard deviation of its noise. Coefficients above the compared band are zero.
    """
    ends = np.cumsum([len(run.data) for run in found.runs])
    parts = np.split(found.residuals[: found.count], ends[:-1])
    whitened = [_over_time(run, part[:, None])[:, :, 0] for run, part in zip(found.runs, parts, strict=True)]
    return [one * np.sqrt(one.size / len(part)) for one, part in zip(whitened, parts, strict=True)]


def output_scale(found: Fit) -> np.ndarray:
    """The root mean square (outputs,) of the noise's standard deviations of each output over all runs, in its unit."""
    outputs = found.runs[0].reduction.outputs
    power = np.zeros(outputs)
    for run in found.runs:
        owner = run.reduction.output_of
        power += [float(np.mean(run.deviation[owner == output] ** 2)) for output in range(outputs)]
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
