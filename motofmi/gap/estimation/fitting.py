"""Base and effects fitted to all runs together, where the base may change a little from run to run.

    chi2 = sum_r |z_r - m_r(theta + d_r, e)|^2 + sum_r |d_r / spread|^2 + |(theta - known) / error|^2

theta are logarithms of the base's parameters, d_r their deviations in run r, e the effects' parameters. d_r is free
under its prior, since otherwise a rider who changes by 3 % between runs would be fitted as an effect. Effects stay
within their bounds, which include the physical sign.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmus.effects.prior import LogNormalPrior
from fmus.support.errors import InputError
from motofmi.gap.estimation.fit_result import (
    Fit,
    deviations_of_runs,
    initial_guesses,
    places_of,
    run_to_run_deviations,
    vector_of,
    with_initial_guesses,
)
from motofmi.gap.estimation.levenberg_marquardt import levenberg_marquardt
from motofmi.gap.models.any_model import AnyModel, AnyRun
from motofmi.gap.models.segment_unknowns import SegmentStart

ITERATIONS = 40  # most iterations of a fit; about 20 are needed where a mode is far from its start
ENOUGH = 0.05  # gain of chi-square by a step below which the fit ends
AT_BOUND = 1e-6  # relative difference within which a parameter is at its bound
# Change of the residuals by a factor e in a parameter: below the first the data do not determine it, the second is that
# of its new start, and the third bounds the factor.
INSENSITIVE, SENSITIVE, LEAST_SENSITIVITY = 1.0, 10.0, 1e-3
# lower bound of a parameter of the base in its unit; of its value if that is less
LEAST_VALUE, LEAST_SHARE = 1e-6, 1e-3
LARGEST_OFFSET = 10.0  # bound of a sensor offset over its standard deviation


def with_sensitive_base(found: Fit) -> np.ndarray:
    """x with vanishing parameters of the base increased until the data are sensitive to them; a fit of their logarithms
    would keep them at zero."""
    x, base = found.x.copy(), len(found.model.base)
    # of a factor e; in proportion to the parameter where it is small
    sensitivity = np.linalg.norm(found.jacobian[:, :base], axis=0)
    factor = SENSITIVE / np.maximum(sensitivity, LEAST_SENSITIVITY)
    x[:base] += np.where(sensitivity < INSENSITIVE, np.log(factor), 0.0)
    return x


def has_vanished_parameter(found: Fit) -> bool:
    """Whether a parameter of the base ended at its lower bound, where the derivatives are not representative of the
    gain of an effect."""
    low = _bounds(found.model, found.runs, len(found.x))[0]
    return bool(np.any(found.x[: len(found.model.base)] <= low[: len(found.model.base)] + AT_BOUND))


def shape_at_bound(found: Fit) -> tuple[str, str] | None:
    """The first parameter of an effect that ended at its least share of the largest deflection (`Effect.at_least`) or
    signal (`at_least_of_level`), or at its largest share of the largest rate (`at_most_of_rate`), beyond which the
    effect is not distinguishable from another one: its name, and "least" or "largest"; None where none did."""
    ends = {"at_least": "least", "at_least_of_level": "least", "at_most_of_rate": "largest"}
    places = [(i, end) for effect in found.model.effects for bounded, end in ends.items()
              for i in places_of(found, effect, tuple(getattr(effect, bounded)))]  # fmt: skip
    low, high = _bounds(found.model, found.runs, len(found.x)) if places else (found.x, found.x)
    for i, end in places:
        if found.x[i] <= low[i] * (1 + AT_BOUND) if end == "least" else found.x[i] >= high[i] * (1 - AT_BOUND):
            return found.model.names[i], end
    return None


def fit(model: AnyModel, runs: Sequence[AnyRun], start: np.ndarray, frozen: Sequence[int] = (),
        iterations: int = ITERATIONS, gain: float = ENOUGH, beat: float = np.inf,
        most: float = np.inf) -> Fit:  # fmt: skip
    """The fit from a start: the model's vector, or the whole vector x with the deviations of each run.

    Parameters in `frozen` (indices) keep their start values. A fit that cannot reach the chi-square `beat` within some
    steps is ended early, and one whose start has a chi-square above `most` is not begun. Raises InputError where the
    start cannot be simulated.
    """
    runs = with_initial_guesses(runs, initial_guesses(runs))
    total = len(model.names) + len(runs) * len(run_to_run_deviations(model.experiment))
    x = np.concatenate([start, np.zeros(total - len(start))])
    low, high = _bounds(model, runs, total)
    free = np.setdiff1d(np.arange(total), np.asarray(list(frozen), int))
    x[free] = np.clip(x[free], low[free], high[free])
    problem = _Problem(model, runs, total)
    solved = levenberg_marquardt(
        problem, x, (low, high), free, lambda x: _reach(model, x), gain, beat, most, iterations
    )
    # From the initial states of a rejected x the best one may diverge.
    count = sum(len(run.data) for run in runs)
    return Fit(model, problem.best_runs, solved.x, solved.chi2, solved.residuals, solved.jacobian, count)


def one_step(model: AnyModel, runs: Sequence[AnyRun], x: np.ndarray) -> float:
    """The chi-square that a step of Gauss and Newton from x is expected to reach. Raises InputError as `fit`."""
    problem = _Problem(model, list(with_initial_guesses(runs, initial_guesses(runs))), len(x))
    residuals, jacobian = problem.residuals(x), problem.slopes(x)
    scale = np.linalg.norm(jacobian, axis=0) + 1e-12
    left = residuals + (jacobian / scale) @ np.linalg.lstsq(jacobian / scale, -residuals, rcond=None)[0]
    return float(left @ left)


def fit_or_none(model: AnyModel, runs: Sequence[AnyRun], start: np.ndarray) -> Fit | None:
    """The fit from a start; None where the start cannot be simulated."""
    try:
        return fit(model, runs, start)
    except InputError:
        return None


def _bounds(model: AnyModel, runs: Sequence[AnyRun], total: int) -> tuple[np.ndarray, np.ndarray]:
    shares = {
        model.experiment.parameter(e, n): (e.at_least.get(n, -np.inf), e.at_most.get(n, np.inf))
        for e in model.effects
        for n in (*e.at_least, *e.at_most)
    }
    largest = model.largest(runs) if shares else 1.0
    own = [(r, *shares.get(n, (-np.inf, np.inf))) for n, r in zip(model.own, model.rows, strict=True)]
    shares_of_values = {n: LEAST_SHARE * abs(model.component.values[n]) for n in model.base}
    least_values = {n: min(LEAST_VALUE, share) if share > 0 else LEAST_VALUE for n, share in shares_of_values.items()}
    smallest, greatest = model.magnitudes
    low = list(np.log(np.maximum(smallest, list(least_values.values()))))
    sliding = _rates(model, "at_least_sliding", getattr(model.experiment, "sliding_rate", 0.0))
    low += [
        max(r.min, least * largest, sliding.get(n, -np.inf)) for n, (r, least, _) in zip(model.own, own, strict=True)
    ]
    fast = _rates(model, "at_most_of_rate", getattr(model.experiment, "largest_rate", np.inf))
    high = list(np.log(greatest))
    high += [min(r.max, most * largest, fast.get(n, np.inf)) for n, (r, _, most) in zip(model.own, own, strict=True)]
    places, sizes = deviations_of_runs(model, total)
    rest = np.where(places < len(model.base), 1.0, LARGEST_OFFSET * sizes)
    return np.concatenate([low, -rest]), np.concatenate([high, rest])


def _rates(model: AnyModel, bounded: str, rate: float) -> dict[str, float]:
    """The bounds, by the name of the parameter, that an attribute of the effects gives as shares of a rate."""
    return {model.experiment.parameter(e, n): k * rate for e in model.effects for n, k in getattr(e, bounded).items()}


def _reach(model: AnyModel, x: np.ndarray) -> np.ndarray:
    """The largest change (n,) in one step: a factor of two, except for the magnitudes of effects, in which the output
    is nearly linear."""
    reach = np.full(len(x), 0.7)
    nb = len(model.base)
    for i in range(len(model.own)):
        reach[nb + i] = np.inf if i in model.sizes else 0.7 * abs(x[nb + i])
    for places, prior in priors_of_effects(model):
        reach[places] = 0.7 * (x[places] + prior.offset)
    reach[len(model.names) :] = np.where(deviations_of_runs(model, len(x))[0] < nb, 0.7, np.inf)
    return reach


class _Problem:
    """Residuals in units of the noise, those of the priors last, and their slopes by x."""

    def __init__(self, model: AnyModel, runs: list[AnyRun], total: int):
        self.model, self.deviating = model, list(run_to_run_deviations(model.experiment))
        self.runs: list[Any] = runs  # some have initial guesses, which a simulation changes
        self.predicted = getattr(model, "predicted", None)
        self.priors, self.known = _priors(model, total)
        self.of_effects = priors_of_effects(model)
        self.kept: dict[int, np.ndarray] = {}  # slopes that came with the output
        self.best_runs = runs  # with the initial guesses of the best x so far
        self.least = np.inf  # chi-square of the best x so far; all x after the first one are trials
        self.last = np.inf  # chi-square of the last x that was solved completely

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """(m,). Raises InputError where the model cannot be simulated; the runs' initial guesses are then as before.

        In a trial whose chi-square is above the least one to first order in the initial states, the residuals are those
        to first order: the trial is rejected.
        """
        kept = [guess and {key: dict(known) for key, known in guess.items()} for guess in initial_guesses(self.runs)]
        try:
            begun = self._begun(x)
            if begun:
                first = self._with_priors([segment.reduced for run in begun for segment in run.values()], x)
                if first @ first > self.least:
                    return first
            left = [self._of_run(index, x, begun) - run.data / run.deviation for index, run in enumerate(self.runs)]
        except InputError:
            for run, guess in zip(self.runs, kept, strict=True):
                if guess is not None:
                    run.guess.clear()
                    run.guess.update(guess)
            raise
        residuals = self._with_priors(left, x)
        self.last = float(residuals @ residuals)
        return residuals

    def accepted(self) -> None:
        """The initial guesses of the runs are those of the best x so far, from which all further x are trials."""
        self.best_runs, self.least = with_initial_guesses(self.runs, initial_guesses(self.runs)), self.last

    def _with_priors(self, residuals: Sequence[np.ndarray], x: np.ndarray) -> np.ndarray:
        of_effects = [prior.residuals(x[places]) for places, prior in self.of_effects]
        return np.concatenate([*residuals, self.priors @ x - self.known, *of_effects])

    def _begun(self, x: np.ndarray) -> list[Mapping[int, SegmentStart]]:
        """The segments of every run simulated once in a trial, where their initial states are unknown."""
        if self.least == np.inf or not hasattr(self.model, "simulated_once"):
            return []
        begun = []
        for index, run in enumerate(self.runs):
            begun.append(self.model.simulated_once(run, vector_of(x, self.model, index)))
            if not begun[-1]:
                return []
        return begun

    def _of_run(self, index: int, x: np.ndarray, begun: Sequence[Mapping[int, SegmentStart]]) -> np.ndarray:
        """The predicted data of a run over the noise."""
        run, q = self.runs[index], vector_of(x, self.model, index)
        if self.predicted is not None:
            return self.predicted(run, q)
        predicted, self.kept[index] = (
            self.model.trial(run, q, begun[index])  # type: ignore[attr-defined]
            if begun
            else self.model.reduced(run, q)
        )
        return predicted

    def slopes(self, x: np.ndarray) -> np.ndarray:
        """(m, len(x)), at the x of the last residuals."""
        shared, deviating, rows = len(self.model.names), self.deviating, []
        for index, run in enumerate(self.runs):
            slopes = (
                self.kept[index] if index in self.kept else self.model.reduced(run, vector_of(x, self.model, index))[1]
            )
            block = np.zeros((len(slopes), len(x)))
            block[:, :shared] = slopes
            block[:, shared + index * len(deviating) : shared + (index + 1) * len(deviating)] = slopes[:, deviating]
            rows.append(block)
        of_effects = [np.zeros((len(places), len(x))) for places, _ in self.of_effects]
        for block, (places, prior) in zip(of_effects, self.of_effects, strict=True):
            block[:, places] = prior.slopes(x[places])
        return np.concatenate([*rows, self.priors, *of_effects])


def priors_of_effects(model: AnyModel) -> list[tuple[list[int], LogNormalPrior]]:
    """The priors of effects, with the indices of their parameters in the model's vector."""
    return [
        ([model.names.index(model.experiment.parameter(e, n)) for n in e.prior.names], e.prior)
        for e in model.effects
        if e.prior
    ]


def _priors(model: AnyModel, total: int) -> tuple[np.ndarray, np.ndarray]:
    """The priors as linear equations: rows (k, total) times x = known (k,), in units of the standard deviations."""
    sizes, shared = deviations_of_runs(model, total)[1], len(model.names)
    rows, known = [np.zeros(total) for _ in sizes], [0.0] * len(sizes)
    for at, (row, size) in enumerate(zip(rows, sizes, strict=True)):
        row[shared + at] = 1 / size
    for i, free in enumerate(model.experiment.free):
        if free.known is not None:
            weight = free.known / free.standard_error
            rows.append(np.zeros(total))
            rows[-1][i] = weight
            known.append(float(np.log(free.known)) * weight)
    for name, (value, error) in model.experiment.measured_effects.items():
        # Another test measured the magnitude of this effect; in a model without the effect it is zero.
        rows.append(np.zeros(total))
        if name in model.names:
            rows[-1][model.names.index(name)] = 1 / error
        known.append(value / error)
    return np.array(rows).reshape(len(rows), total), np.array(known)
