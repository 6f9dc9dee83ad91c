"""The initial fit of a base whose start values may be inaccurate: over short intervals first, then over longer ones.

With free initial states of each interval, a wrong frequency causes only a small phase error, and the fit has few
minima. Its result starts the fit over longer intervals, and finally over whole segments. The runs of an unstable
component stay cut into intervals over which its free motion grows by at most GROWTH or GROWTH_OF_SEVERAL.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from fmus.effects.measuring_channel import ChannelDelay
from fmus.effects.placement import delay_in_motion
from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError
from fmus.support.parallel import in_turn, parallel_map
from motofmi.gap.estimation.double_integrator import is_double_integrator, longest_segment
from motofmi.gap.estimation.fit_result import Fit, PortableFit
from motofmi.gap.estimation.fitting import fit, fit_or_none
from motofmi.gap.estimation.friction_transition import has_transition, in_best_width
from motofmi.gap.estimation.starting_values import MAX_ITERATIONS, first_values, poles, values_by_inverse_dynamics
from motofmi.gap.experiments.state_rates import rates_of_states
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.flexible_noise_model import Density
from motofmi.gap.preprocessing.input_interpolation import HELD, INTERPOLATIONS, is_held, is_rough
from motofmi.gap.preprocessing.sampled_run import SampledRun, excited
from motofmi.gap.preprocessing.segments import LEAST_LENGTH

STRETCHES = (1.0, 3.0)  # interval lengths in periods of the motion's mean frequency
MOST = 24  # intervals of a run in the first stages
# Factor of an unstable motion over a segment, with one and with several degrees of freedom: of several coupled ones
# the simulation differs sooner from the recorded motion by more than initial states can correct.
GROWTH, GROWTH_OF_SEVERAL = 20.0, 5.0
POINTS = 500  # samples of a run at which its component is linearised
GOOD = 2.0  # reduced chi-square below which no other start is tried
SAME = 0.02  # relative difference of reduced chi-square within which two starts have reached the same minimum
OUT_OF_REACH = 2.0  # ratio of chi-square to that of the best start above which a start that gains little is given up
CLOSER = 0.9  # ratio of chi-square that another interpolation of the inputs must reach
HOLD_DELAY = 0.5  # samples by which a held input is late
DELAY_ERROR = 0.1  # samples by which the misfit of a base may change a fitted delay


def initial_fit(model: FreeInitialStateModel, runs: Sequence[SampledRun]) -> Fit:
    """The base fitted from several starts; its runs are cut where the base is unstable.

    Raises InputError where no start can be simulated.
    """
    best: Fit | None = None
    if (start := values_by_inverse_dynamics(model, runs)) is not None:
        best = min(_from_start(model, runs, start, np.inf), key=lambda found: found.reduced, default=None)
    for start in first_values(model, runs) if best is None else ():
        before, of_start = best, None
        beat = np.inf if best is None else OUT_OF_REACH * best.chi2
        for found in _from_start(model, runs, start, beat):
            again, same = (other is not None and _alike(found, other) for other in (before, of_start))
            best = found if best is None or found.reduced < best.reduced else best
            if best.reduced < GOOD or again or time_is_up():
                return with_best_interpolation(model, best)
            of_start = found
            if same:  # intervals of other lengths lead to the same minimum
                break
    if best is None:
        raise InputError(f"{model.component.name} cannot be simulated near its parameter values; expected values of "
                         "the order of those of the "
                         "recorded component: give them in a value file, --component FILE.toml")  # fmt: skip
    return with_best_interpolation(model, best)


def _alike(one: Fit, other: Fit) -> bool:
    """Whether two fits have reached the same minimum."""
    return max(one.reduced, other.reduced) < (1 + SAME) * min(one.reduced, other.reduced)


def _from_start(
    model: FreeInitialStateModel, runs: Sequence[SampledRun], start: np.ndarray, beat: float
) -> Iterator[Fit]:
    """The fits from a start that can be simulated: over all intervals, the longer ones, whole segments only."""

    def staged(periods: Sequence[float]) -> tuple[PortableFit | None, np.ndarray]:
        x = start
        try:
            for each in periods:
                short = [
                    _excerpt(stable_segments(model, x, run), int(each * run.recording.rate / run.middle_frequency))
                    for run in runs
                ]
                x = fit(model, short, x, iterations=MAX_ITERATIONS).x
            stable = [stable_segments(model, x, run) for run in runs]
            return PortableFit.of(fit(model, stable, x, iterations=MAX_ITERATIONS, beat=beat)), x
        except InputError:
            return None, x

    for portable, x in in_turn([partial(staged, STRETCHES[skipped:]) for skipped in range(len(STRETCHES) + 1)]):
        if portable is not None:
            yield portable.on(model, [stable_segments(model, x, run) for run in runs])


def _excerpt(run: SampledRun, length: int) -> SampledRun:
    """Some of the run's short intervals, evenly distributed over it."""
    cut = run.cut(max(length, 16))
    if len(cut.segments) <= MOST:
        return cut
    keep = np.unique(np.linspace(0, len(cut.segments) - 1, MOST).astype(int))
    reduction = cut.reduction
    chosen = {int(k): i for i, k in enumerate(keep)}
    places = [i for i, owner in enumerate(reduction.segment_of) if owner in chosen]
    sizes = np.cumsum([0] + [kept * reduction.outputs for _, _, kept in reduction.spans])
    rows = np.concatenate([np.arange(sizes[i], sizes[i + 1]) for i in places])
    spans, owners = [reduction.spans[i] for i in places], [chosen[reduction.segment_of[i]] for i in places]
    fewer = replace(reduction, spans=spans, segment_of=owners, columns=[reduction.columns[i] for i in rows])
    return replace(
        cut,
        segments=[cut.segments[i] for i in keep],
        reduction=fewer,
        data=cut.data[rows],
        deviation=cut.deviation[rows],
        guess={},
    )


def stable_segments(model: FreeInitialStateModel, x: np.ndarray, run: SampledRun) -> SampledRun:
    """The run, cut where the component's unstable free motion would grow too far over a segment; a run that is cut
    for another model also where that needs it. A double integrator has no such growth, and its errors grow all the
    same: see `double_integrator`.

    The component is linearised along the recorded motion: a pendulum is unstable about its upper equilibrium only.
    """
    samples = len(run.measured)
    points = np.unique(np.linspace(0, samples - 1, min(samples, POINTS)).astype(int))
    component, recorded = model.component, run.recording.columns
    at = {n: run.recording[n][points] for n in (*component.states, *component.inputs) if n in recorded}
    found = poles(model, x, **at)
    growth = np.max(found.real, axis=-1, initial=0.0)
    moving = sum(map(bool, rates_of_states(model.experiment.component).values()))
    several = moving > 1
    most = np.log(GROWTH_OF_SEVERAL if several else GROWTH)
    allowed = np.clip(most / np.maximum(growth, 1e-9) * run.recording.rate, LEAST_LENGTH, samples)
    longest = max(last - first for first, last in run.segments)
    limit = run.longest_of_integrator
    if moving and excited([run]) and is_double_integrator(found, longest / run.recording.rate):
        limit = longest_segment(run.middle_frequency)
        allowed = np.minimum(allowed, max(limit * run.recording.rate, LEAST_LENGTH))
    if np.all(allowed >= longest):
        return run
    lengths = np.interp(np.arange(samples), points, np.broadcast_to(allowed.astype(int), points.shape))
    if run.stable_length is not None:
        lengths = np.minimum(lengths, run.stable_length)
    return replace(run, stable_length=lengths, longest_of_integrator=limit).cut(longest)


def with_best_interpolation(model: FreeInitialStateModel, found: Fit) -> Fit:
    """The fit with that interpolation of the inputs that fits best, where an input is rough between its samples, held
    between changes, or where half a sample, by which a held input is late, may be a part of the misfit."""
    runs = found.runs
    inputs = [run.recording[n] for run in runs for n in run.experiment.inputs if n != run.experiment.imposed]
    power = sum(float(np.sum((run.data / run.deviation) ** 2)) for run in runs)
    late = max((_change_by_half_a_sample(values) for values in inputs), default=0.0)
    may_be_late = late**2 * power > (1 - CLOSER) * found.chi2
    if not (may_be_late or any(is_rough(values) or is_held(values) for values in inputs)):
        return found
    others = [[run.with_interpolation(kind) for run in runs] for kind in INTERPOLATIONS if kind != runs[0].kind]
    fits = parallel_map(
        lambda other: PortableFit.of(fit_or_none(model, other, found.x)), others, "fitting with other interpolations"
    )
    for portable, other in zip(fits, others, strict=True):
        if portable is None or portable.chi2 >= CLOSER * found.chi2:
            continue
        if not (other[0].kind == HELD and _is_delayed(model, found, portable.chi2)):
            found = portable.on(model, other)
    return found


def _is_delayed(model: FreeInitialStateModel, found: Fit, held: float) -> bool:
    """Whether the output is late for another reason than held inputs, whose chi-square is `held`: a free delay fits
    clearly better, and is not the half sample of a hold."""
    if any(effect.family == ChannelDelay.family for effect in model.effects):
        return False
    run, shared = found.runs[0], len(model.names)
    delayed = model.with_added_effects(delay_in_motion(1 / run.middle_frequency))
    late = fit_or_none(delayed, found.runs, np.insert(found.x, shared, HOLD_DELAY / run.recording.rate))
    if late is None or late.chi2 > CLOSER * held:
        return False
    return bool(abs(late.x[shared] * run.recording.rate - HOLD_DELAY) > DELAY_ERROR)


def _change_by_half_a_sample(values: np.ndarray) -> float:
    """The change (rms) of a signal (n,) in half of its sampling interval, over its rms about the mean."""
    return float(np.sqrt(np.mean(np.diff(values) ** 2)) / max(2 * np.std(values), 1e-300))


def in_interpolation_of(best: Fit, base: Fit) -> Fit | None:
    """A base with the interpolation of the inputs that fits best with an effect, which the misfit of the base may hide;
    None where it is that of the base, or where the base cannot be simulated or fits clearly worse with it: held inputs
    are nearly those of another interpolation with a delay of half a sample.

    Dry friction has the transition of the best width, since the misfit of a wide one is larger than that of an interpolation.
    """
    narrow = in_best_width(best) if has_transition(best.model.effects) else best
    model: Any = narrow.model
    kind = with_best_interpolation(model, narrow).runs[0].kind
    if kind == base.runs[0].kind:
        return None
    found = _in_interpolation(base, kind)
    return None if found is None or found.chi2 > OUT_OF_REACH * base.chi2 else found


def unless_held(base: Fit) -> Fit | None:
    """A base with held inputs, fitted again with smooth ones, in the same noise: an effect that lags may be a part of
    the half sample by which held inputs are late. None where inputs are not held, or where their samples show steps."""
    run = base.runs[0]
    if run.kind != HELD or any(is_held(run.recording[n]) for n in run.experiment.inputs):
        return None
    return _in_interpolation(base, INTERPOLATIONS[0])


def _in_interpolation(base: Fit, kind: str) -> Fit | None:
    """A base fitted again with another interpolation of the inputs, in the same noise; None where it cannot be
    simulated with it."""
    runs = [
        replace(run.with_interpolation(kind), input_variance=None).with_densities(run.densities, run.noise_source)
        for run in base.runs
    ]
    return fit_or_none(base.model, runs, base.x)


def equal_noise(runs: Sequence[SampledRun], found: Fit) -> list[SampledRun]:
    """The runs with noise scaled to the residuals of the fit: a first estimate where the base does not fit."""
    wider, first = [], 0
    for run in runs:
        last = first + len(run.data)
        scale = float(np.mean(found.residuals[first:last] ** 2))
        wider.append(
            run.with_densities([Density(d.frequency, d.density * scale) for d in run.densities], run.noise_source)
        )
        first = last
    return wider
