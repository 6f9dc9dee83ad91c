"""Base and effects fitted to all runs together, where the base may change a little from run to run.

    chi2 = sum_r |z_r - m_r(theta + d_r, e)|^2 + sum_r |d_r / spread|^2 + |(theta - known) / error|^2

theta are logarithms of the base's parameters, d_r their deviations in run r, e the effects' parameters. Tied across
runs, a rider who changes by 3 % looks like an effect; so d_r is free under its prior. Levenberg-Marquardt with exact
slopes; effects stay within their bounds, which hold the physical sign.
"""

from collections.abc import Sequence

import numpy as np

from fmus.errors import InputError
from identification.gap.models.model import AnyModel, AnyRun
from identification.gap.naming.fitted import Fit, deviating, memories, of_runs, remembering, vector_of

ITERATIONS = 40  # a mode that is far from its start takes some 20
ENOUGH = 0.05  # of chi-square that a further step would gain
COARSE = 1e-3  # of it, as long as the fit is far from the data
AT_BOUND = 1e-6  # of a logarithm: nearer to a bound, it is there
UNFELT, FELT, LEAST_FELT = 1.0, 10.0, 1e-3  # change of the residuals by a factor e in a parameter
HOPE = 20.0  # steps like the next one that a fit may need to reach what it should beat
MOST_OFF = 10.0  # deviations that the zero of a sensor may be off
ASTRAY = 1e8  # times the chi-square that is to be beaten: from there, a simulation that has lost its way rarely finds back


def with_all_felt(found: Fit) -> np.ndarray:
    """x with the base's parameters that have all but vanished as large as the data begin to feel: logarithms would hold them."""
    x, base = found.x.copy(), len(found.model.base)
    felt = np.linalg.norm(found.jacobian[:, :base], axis=0)  # of a factor e; in proportion to the parameter where it is small
    x[:base] += np.where(felt < UNFELT, np.log(FELT / np.maximum(felt, LEAST_FELT)), 0.0)
    return x


def lost(found: Fit) -> bool:
    """Whether a parameter of the base ended where it all but vanishes: small steps from there say little of what an effect would do."""
    low = _bounds(found.model, found.runs, len(found.x))[0]
    return bool(np.any(found.x[: len(found.model.base)] <= low[: len(found.model.base)] + AT_BOUND))


def fit(model: AnyModel, runs: Sequence[AnyRun], start: np.ndarray, frozen: Sequence[int] = (), anchor: np.ndarray | None = None,
        iterations: int = ITERATIONS, gain: float = ENOUGH, beat: float = np.inf) -> Fit:  # fmt: skip
    """The fit from a start: the model's vector, or a whole x. Parameters in `frozen` (indices) stay.

    anchor gives common values of theta that are known from other runs, instead of fitting them. A fit that creeps far
    above the chi-square `beat` ends where it is; one that starts astray does not begin.
    """
    runs = remembering(runs, memories(runs))
    shared, total = len(model.names), len(model.names) + len(runs) * len(deviating(model.stand))
    x = np.concatenate([start, np.zeros(total - len(start))])
    if anchor is not None:
        frozen = range(shared)
    low, high = _bounds(model, runs, total)
    free = np.setdiff1d(np.arange(total), np.asarray(list(frozen), int))
    x[free] = np.clip(x[free], low[free], high[free])
    problem = _Problem(model, runs, total)
    residuals, jacobian = problem.residuals(x), problem.slopes(x)
    chi2, damping = float(residuals @ residuals), 1e-3
    for _ in range(iterations if chi2 < ASTRAY * beat else 0):
        gradient = jacobian.T @ residuals
        open_ = [i for i in free if not (x[i] <= low[i] and gradient[i] > 0) and not (x[i] >= high[i] and gradient[i] < 0)]
        part = jacobian[:, open_]
        normal = part.T @ part
        scale = np.sqrt(np.diag(normal)) + 1e-9
        reach, accepted = _reach(model, x), False
        worth = max(gain, COARSE * chi2) if chi2 > 2 * len(residuals) else gain
        for tries in range(8):
            move = np.linalg.solve(normal / np.outer(scale, scale) + damping * np.eye(len(open_)), -gradient[open_] / scale) / scale
            steps = [np.clip(x[open_] + each, low[open_], high[open_]) - x[open_] for each in _within(move, reach[open_])]
            gains = [-float(2 * gradient[open_] @ step + step @ normal @ step) for step in steps]
            expected, trial = max(gains), x.copy()
            trial[open_] += steps[gains.index(expected)]
            hoped = max(expected, -float(2 * gradient[open_] @ move + move @ normal @ move))  # a step that may not go far says little of what is to come
            if expected < worth or (not tries and chi2 - HOPE * hoped > beat):
                break
            try:
                new_residuals = problem.residuals(trial)
                new = float(new_residuals @ new_residuals)
            except InputError:  # the trial diverges: a shorter step
                new = np.inf
            if new < chi2:
                accepted = True
                break
            damping *= 6
        if not accepted:
            break
        x, residuals, won, chi2 = trial, new_residuals, chi2 - new, new
        if won > gain:  # else the slopes have not moved either
            jacobian = problem.slopes(x)
        if won > 0.75 * expected and not tries:
            damping = max(damping / 10, 1e-9)
        if won < worth:
            break
    return Fit(model, runs, x, chi2, residuals, jacobian, sum(len(r.data) for r in runs))


def attempt(model: AnyModel, runs: Sequence[AnyRun], start: np.ndarray) -> Fit | None:
    """The fit from a start; None where nothing can be simulated from there."""
    try:
        return fit(model, runs, start)
    except InputError:
        return None


def _bounds(model: AnyModel, runs: Sequence[AnyRun], total: int) -> tuple[np.ndarray, np.ndarray]:
    table = model.component.table
    shares = {model.stand.parameter(e, n): (e.at_least.get(n, -np.inf), e.at_most.get(n, np.inf)) for e in model.effects for n in (*e.at_least, *e.at_most)}
    largest = model.largest(runs) if shares else 1.0
    own = [(r, *shares.get(n, (-np.inf, np.inf))) for n, r in zip(model.own, model.rows, strict=True)]
    low = [np.log(max(table[n].min, 1e-6)) for n in model.base] + [max(r.min, least * largest) for r, least, _ in own]
    high = [np.log(table[n].max) for n in model.base] + [min(r.max, most * largest) for r, _, most in own]
    places, sizes = of_runs(model, total)
    rest = np.where(places < len(model.base), 1.0, MOST_OFF * sizes)
    return np.concatenate([low, -rest]), np.concatenate([high, rest])


def _within(move: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A move within its reach: every parameter by itself, which may turn it the wrong way; or all by one factor."""
    return np.clip(move, -reach, reach), move * min(1.0, float(np.min(reach / (np.abs(move) + 1e-300), initial=1.0)))


def _reach(model: AnyModel, x: np.ndarray) -> np.ndarray:
    """How far one step may go: by a factor of two, besides the sizes of effects, in which the output is nearly linear."""
    reach = np.full(len(x), 0.7)
    nb = len(model.base)
    for i in range(len(model.own)):
        reach[nb + i] = np.inf if i in model.sizes else 0.7 * abs(x[nb + i])
    reach[len(model.names) :] = np.where(of_runs(model, len(x))[0] < nb, 0.7, np.inf)
    return reach


class _Problem:
    """Residuals in units of the noise, those of the priors last, and their slopes by x."""

    def __init__(self, model: AnyModel, runs: list[AnyRun], total: int):
        self.model, self.runs, self.moved = model, runs, list(deviating(model.stand))
        self.predicted = getattr(model, "predicted", None)
        self.priors, self.known = _priors(model, total)
        self.kept: dict[int, np.ndarray] = {}  # slopes that came with the output

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """(m,). Raises InputError where the model cannot be simulated."""
        left = []
        for index, run in enumerate(self.runs):
            q = vector_of(x, self.model, index)
            if self.predicted is None:
                predicted, self.kept[index] = self.model.reduced(run, q)
            else:
                predicted = self.predicted(run, q)
            left.append(predicted - run.data / run.deviation)
        return np.concatenate([*left, self.priors @ x - self.known])

    def slopes(self, x: np.ndarray) -> np.ndarray:
        """(m, len(x)), where the residuals were asked for last."""
        shared, moved, rows = len(self.model.names), self.moved, []
        for index, run in enumerate(self.runs):
            slopes = self.kept[index] if index in self.kept else self.model.reduced(run, vector_of(x, self.model, index))[1]
            block = np.zeros((len(slopes), len(x)))
            block[:, :shared] = slopes
            block[:, shared + index * len(moved) : shared + (index + 1) * len(moved)] = slopes[:, moved]
            rows.append(block)
        return np.concatenate([*rows, self.priors])


def _priors(model: AnyModel, total: int) -> tuple[np.ndarray, np.ndarray]:
    """What is known beside the data, as rows (k, total) times x = known (k,), in units of the errors."""
    sizes, shared = of_runs(model, total)[1], len(model.names)
    rows, known = [np.zeros(total) for _ in sizes], [0.0] * len(sizes)
    for at, (row, size) in enumerate(zip(rows, sizes, strict=True)):
        row[shared + at] = 1 / size
    for i, free in enumerate(model.stand.free):
        if free.known is not None:
            weight = free.known / free.standard_error
            rows.append(np.zeros(total))
            rows[-1][i] = weight
            known.append(float(np.log(free.known)) * weight)
    for name, (value, error) in model.stand.measured_effects.items():
        # Another test measured this effect's size; a model without the effect says zero.
        rows.append(np.zeros(total))
        if name in model.names:
            rows[-1][model.names.index(name)] = 1 / error
        known.append(value / error)
    return np.array(rows).reshape(-1, total), np.array(known)
