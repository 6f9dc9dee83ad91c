"""Base and effects fitted to all runs together, where the base may change a little from run to run.

    chi2 = sum_r |z_r - m_r(theta + d_r, e)|^2 + sum_r |d_r / spread|^2 + |(theta - known) / error|^2

theta are logarithms of the base's parameters, d_r their deviations in run r, e the effects' parameters. Tied across
runs, a rider who changes by 3 % looks like an effect; so d_r is free under its prior. Levenberg-Marquardt with exact
slopes; effects stay within their bounds, which hold the physical sign.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmus.errors import InputError
from identification.gap.model import AnyModel, AnyRun, AnyStand

ITERATIONS = 15
ENOUGH = 0.05  # of chi-square that a further step would gain
COARSE = 1e-3  # of it, as long as the fit is far from the data


@dataclass
class Fit:
    """A fitted model. x holds [theta, e, d_1, d_2, ...]; residuals and their jacobian the priors at the end."""

    model: AnyModel
    runs: list[Any]  # AnyRun; whoever draws them knows more of them
    x: np.ndarray
    chi2: float
    residuals: np.ndarray
    jacobian: np.ndarray
    count: int  # reduced data

    @property
    def shared(self) -> np.ndarray:
        """The parameters that all runs have in common: the model's vector."""
        return self.x[: len(self.model.names)]

    @property
    def freedom(self) -> int:
        """Data and priors, less what was fitted."""
        return len(self.residuals) - len(self.x)

    @property
    def reduced(self) -> float:
        """Chi-square per degree of freedom: 1 at the noise floor."""
        return self.chi2 / self.freedom

    def covariance(self) -> np.ndarray:
        """Of x; what the data do not determine has a large one."""
        scale = np.linalg.norm(self.jacobian, axis=0) + 1e-12
        u = np.linalg.pinv(self.jacobian / scale, rcond=1e-9)
        return (u @ u.T) / np.outer(scale, scale)

    def of_run(self, index: int) -> np.ndarray:
        """The model's vector for one run."""
        return _vector(self.x, self.model, index)


def deviating(stand: AnyStand) -> list[int]:
    """The free parameters that change from run to run."""
    return [i for i, f in enumerate(stand.free) if f.spread > 0]


def _vector(x: np.ndarray, model: AnyModel, index: int) -> np.ndarray:
    moved = deviating(model.stand)
    shared = len(model.names)
    q = x[:shared].copy()
    q[moved] += x[shared + index * len(moved) : shared + (index + 1) * len(moved)]
    return q


def fit(model: AnyModel, runs: Sequence[AnyRun], start: np.ndarray, frozen: Sequence[int] = (), anchor: np.ndarray | None = None,
        iterations: int = ITERATIONS, gain: float = ENOUGH) -> Fit:  # fmt: skip
    """The fit from a start: the model's vector, or a whole x. Parameters in `frozen` (indices) stay.

    anchor gives common values of theta that are known from other runs, instead of fitting them.
    """
    runs = list(runs)
    moved = deviating(model.stand)
    shared, total = len(model.names), len(model.names) + len(runs) * len(moved)
    x = np.concatenate([start, np.zeros(total - len(start))])
    if anchor is not None:
        frozen = range(shared)
    low, high = _bounds(model, total)
    x = np.clip(x, low, high)
    free = np.setdiff1d(np.arange(total), np.asarray(list(frozen), int))
    residuals, jacobian = _assembled(model, runs, x)
    chi2, damping = float(residuals @ residuals), 1e-3
    for _ in range(iterations):
        gradient = jacobian.T @ residuals
        open_ = [i for i in free if not (x[i] <= low[i] and gradient[i] > 0) and not (x[i] >= high[i] and gradient[i] < 0)]
        part = jacobian[:, open_]
        normal = part.T @ part
        scale = np.sqrt(np.diag(normal)) + 1e-9
        reach, accepted = _reach(model, x), False
        worth = max(gain, COARSE * chi2) if chi2 > 2 * len(residuals) else gain
        for _ in range(8):
            move = np.linalg.solve(normal / np.outer(scale, scale) + damping * np.eye(len(open_)), -gradient[open_] / scale) / scale
            trial = x.copy()
            trial[open_] = np.clip(x[open_] + np.clip(move, -reach[open_], reach[open_]), low[open_], high[open_])
            step = trial[open_] - x[open_]
            expected = -float(2 * gradient[open_] @ step + step @ normal @ step)
            if expected < worth:
                break
            try:
                new_residuals, new_jacobian = _assembled(model, runs, trial)
                new = float(new_residuals @ new_residuals)
            except InputError:  # the trial diverges: a shorter step
                new = np.inf
            if new < chi2:
                accepted = True
                break
            damping *= 6
        if not accepted:
            break
        x, residuals, jacobian, won, chi2 = trial, new_residuals, new_jacobian, chi2 - new, new
        damping = max(damping / 6, 1e-9)
        if won < worth:
            break
    return Fit(model, runs, x, chi2, residuals, jacobian, sum(len(r.data) for r in runs))


def _bounds(model: AnyModel, total: int) -> tuple[np.ndarray, np.ndarray]:
    table = model.component.table
    low = [np.log(max(table[n].min, 1e-6)) for n in model.base] + [r.min for r in model.rows]
    high = [np.log(table[n].max) for n in model.base] + [r.max for r in model.rows]
    rest = total - len(low)
    return np.concatenate([low, np.full(rest, -1.0)]), np.concatenate([high, np.full(rest, 1.0)])


def _reach(model: AnyModel, x: np.ndarray) -> np.ndarray:
    """How far one step may go: by a factor of two, besides the sizes of effects, in which the output is nearly linear."""
    reach = np.full(len(x), 0.7)
    nb = len(model.base)
    for i in range(len(model.own)):
        reach[nb + i] = np.inf if i in model.sizes else 0.7 * abs(x[nb + i])
    return reach


def _assembled(model: AnyModel, runs: Sequence[AnyRun], x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residuals, in units of the noise, and their slopes by x; priors last."""
    moved, shared = deviating(model.stand), len(model.names)
    residuals, rows = [], []
    for index, run in enumerate(runs):
        predicted, slopes = model.reduced(run, _vector(x, model, index))
        residuals.append(predicted - run.data / run.deviation)
        block = np.zeros((len(predicted), len(x)))
        block[:, :shared] = slopes
        block[:, shared + index * len(moved) : shared + (index + 1) * len(moved)] = slopes[:, moved]
        rows.append(block)
    for index in range(len(runs)):
        for place, i in enumerate(moved):
            row = np.zeros((1, len(x)))
            at = shared + index * len(moved) + place
            row[0, at] = 1 / model.stand.free[i].spread
            residuals.append(np.array([x[at] * row[0, at]]))
            rows.append(row)
    for i, free in enumerate(model.stand.free):
        if free.known is not None:
            row = np.zeros((1, len(x)))
            row[0, i] = free.known / free.standard_error
            residuals.append(np.array([(x[i] - np.log(free.known)) * row[0, i]]))
            rows.append(row)
    for name, (value, error) in model.stand.measured_effects.items():
        # Another test measured this effect's size; a model without the effect says zero.
        row = np.zeros((1, len(x)))
        size = 0.0
        if name in model.names:
            row[0, model.names.index(name)] = 1 / error
            size = x[model.names.index(name)]
        residuals.append(np.array([(size - value) / error]))
        rows.append(row)
    return np.concatenate(residuals), np.concatenate(rows)


def parameters_of(found: Fit) -> Mapping[str, tuple[float, float, str]]:
    """Value, standard error and unit by name: the base's common values, then the effects'."""
    model, errors = found.model, np.sqrt(np.maximum(np.diag(found.covariance()), 0.0))
    result = {}
    for i, name in enumerate(model.names):
        value = float(np.exp(found.x[i])) if i < len(model.base) else float(found.x[i])
        result[name] = (value, float(errors[i] * value) if i < len(model.base) else float(errors[i]), model.component.table[name].unit)
    return result
