"""The base of a component fitted to sampled runs, with the laws that are candidates at its places."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.effects.placement import laws_at
from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.equation_error import EquationErrorFit, equation_error_fits
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.initial_fit import equal_noise, initial_fit, stable_segments, with_best_interpolation
from motofmi.gap.estimation.sign_change import with_fitted_signs
from motofmi.gap.estimation.single_frequency import inseparable_inertias
from motofmi.gap.estimation.starting_values import within_bounds
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.input_interpolation import INTERPOLATIONS, SMOOTHER
from motofmi.gap.preprocessing.noise_sources import known_noise
from motofmi.gap.preprocessing.one_way import is_one_way, keeps_direction
from motofmi.gap.preprocessing.sampled_run import SampledRun

# Ratio of equation errors above which signs of stiffnesses are those before a change: without the sine of a pendulum
# that goes round, its stiffness may fit with the other sign.
CLEARLY_LESS = 3.0


def fitted_base(
    experiment: InputOutputExperiment,
    runs: Sequence[SampledRun],
    noise: Mapping[str, float],
    library: Sequence[type[Effect]],
    criteria: Criteria,
) -> tuple[Fit, list[type[Effect]], list[EquationErrorFit]]:
    """The base fitted from its initial fit, in the scaled experiment, the candidate effects, and the fits by equation
    error of base and effects.

    The candidates are those of `library` or, where it is empty, the laws at the places of the component. noise holds
    the known standard deviation by output. Segments are short enough for the model with the least equation error to be
    stable over them. Raises InputError where the base cannot be fitted.
    """
    model = FreeInitialStateModel(experiment)
    initial = initial_fit(model, runs)
    fixed = inseparable_inertias(initial, criteria)
    if fixed and len(fixed) < len(experiment.free):
        experiment = replace(experiment, free=tuple(f for f in experiment.free if f.name not in fixed))
        model = FreeInitialStateModel(experiment)
        initial = initial_fit(model, [replace(run, experiment=experiment, guess={}) for run in runs])
    initial = fit(model, equal_noise(initial.runs, initial), initial.x)
    signed = with_fitted_signs(initial, criteria)
    base, candidates = _scaled(signed, noise, library)
    starts = equation_error_fits(base, candidates)
    if signed is not initial:
        before, of_before = _scaled(initial, noise, library)
        with_signs_before = equation_error_fits(before, of_before)
        if starts and with_signs_before and CLEARLY_LESS * with_signs_before[0].chi2 < starts[0].chi2:
            base, candidates, starts = before, of_before, with_signs_before
    if starts and (stable := _on_stable_segments(base, starts[0])) is not None:
        base, _ = _scaled(stable, noise, candidates)
    return base, candidates, starts


def _on_stable_segments(base: Fit, start: EquationErrorFit) -> Fit | None:
    """The base on segments over which a model is stable, with the interpolation of the inputs that fits best with that
    model; None where its segments are short enough, or the model cannot be simulated over them."""
    model, x = start.on(base)
    runs = [_on_segments_of(model, x, run) for run in base.runs]
    if all(run is before for run, before in zip(runs, base.runs, strict=True)):
        return None
    with suppress(InputError):
        found = fit(model, runs, x)
        found = with_best_interpolation(model, fit(model, equal_noise(runs, found), found.x))
        again = fit(base.model, found.runs, base.x)
        return fit(base.model, equal_noise(found.runs, again), again.x)
    return None


def on_segments_like(base: Fit, starts: Sequence[EquationErrorFit], runs: Sequence[SampledRun]) -> list[SampledRun]:
    """Runs on segments over which the model with the least equation error is stable, without one the base."""
    model, x = starts[0].on(base) if starts else (base.model, base.x)
    return [_on_segments_of(model, x, run) for run in runs]


def _on_segments_of(model: Any, x: np.ndarray, run: SampledRun) -> SampledRun:
    """The run itself where its segments are short enough for the model; else on shorter ones, in their band."""
    stable = stable_segments(model, x, run)
    return run if stable is run else stable.with_band_of_segments()


def _scaled(
    initial: Fit, noise: Mapping[str, float], library: Sequence[type[Effect]]
) -> tuple[Fit, list[type[Effect]]]:
    """The base fitted again in the experiment that is scaled to the motion of a fit, and the candidate effects."""
    experiment, runs = initial.model.experiment, initial.runs
    deflection, rate = largest_motion(initial)
    fitted_component = experiment.component.with_values(**fitted_values(initial))
    experiment = replace(experiment, component=fitted_component).scaled(deflection, rate)
    if not library:
        inputs, outputs = _largest(runs, experiment.driven), _largest(runs, experiment.outputs)
        outputs = {n: level for n, level in outputs.items() if not _counts_revolutions(experiment, n, level)}
        states = {} if experiment.imposed else _ranges(initial)
        period = float(np.median([1 / run.middle_frequency for run in runs]))
        library = _distinguishable(laws_at(experiment.component, rate, inputs, outputs, states, period), initial)
    model = FreeInitialStateModel(experiment)
    noisy = [_with_interpolation_error(model, run) for run in known_noise(initial.runs, noise)]
    return fit(model, noisy, model.start()), list(library)


def _with_interpolation_error(model: FreeInitialStateModel, run: SampledRun) -> SampledRun:
    """The run with the additional variance due to inputs that are unknown between their samples.

    It is the squared difference of the model's outputs with two splines through the input.
    """
    if run.kind != INTERPOLATIONS[0]:
        return run
    smooth, smoother = (model.reduced(r, model.start())[0] for r in (run, run.with_interpolation(SMOOTHER)))
    return run.with_input_variance((smooth - smoother) * run.deviation)


def fitted_values(found: Fit) -> dict[str, float]:
    """The fitted parameters of the base by name, within their bounds."""
    model: Any = found.model
    values = within_bounds(model.component, model.values(found.shared))
    return {n: values[n] for n in model.base}


def largest_motion(found: Fit) -> tuple[float, float]:
    """The 99.9 % quantiles of |deflection| and |rate| of the component's first element, the largest of all runs.

    The units are those of the element (m and m/s, or rad and rad/s); both are 1 where there is no element.
    """
    sizes = []
    model: Any = found.model
    for index, run in enumerate(found.runs):
        _, deflections, rates, _ = model.residuals_and_motion(run, found.of_run(index))
        if deflections:
            sizes.append((np.quantile(np.abs(deflections[0]), 0.999), np.quantile(np.abs(rates[0]), 0.999)))
    return tuple(float(max(s)) for s in zip(*sizes, strict=True)) if sizes else (1.0, 1.0)  # type: ignore[return-value]


def _counts_revolutions(experiment: InputOutputExperiment, output: str, level: float) -> bool:
    """Whether an output is an angle [rad] beyond a revolution. The error of its sensor repeats with every revolution,
    where the laws of a sensor grow with the reading."""
    return experiment.component.table[output].unit == "rad" and level > 2 * np.pi


def _distinguishable(library: Sequence[type[Effect]], found: Fit) -> list[type[Effect]]:
    """The laws without those that a motion in one direction does not distinguish from others (see `one_way`)."""
    one_way, elements = _one_way_elements(found), found.model.experiment.component.elements
    recorded = {name for run in found.runs for name in run.recording.columns}
    unseen = {name for name in one_way if elements[name].deflection not in recorded}
    return [
        effect
        for effect in library
        if not (effect.both_ways and effect.element in one_way)
        and not (effect.element in unseen and "deflection" in effect.reads())
    ]


def _one_way_elements(found: Fit) -> set[str]:
    """The elements whose rate has one sign in every run: the recorded one, else that of the fit.

    Where the deflection is recorded, it must keep its direction as well: a free base without stiffness never turns
    back, and the machine may have a spring.
    """
    model: Any = found.model
    one_way = set(model.moving)
    for index, run in enumerate(found.runs):
        _, _, rates, _ = model.residuals_and_motion(run, found.of_run(index))
        recorded = run.recording.columns
        one_way &= {
            (deflection, name)
            for (deflection, name), rate in zip(model.moving, rates, strict=False)  # without elements rates are zero
            if is_one_way(recorded.get(name, rate))
            and (deflection not in recorded or keeps_direction(recorded[deflection]))
        }
    elements = model.experiment.component.elements.items()
    return {name for name, e in elements if (e.deflection or e.rate, e.rate) in one_way}


def _largest(runs: Sequence[SampledRun], names: Sequence[str]) -> dict[str, float]:
    """The 99.9 % quantiles of the moduli of recorded signals by name, the largest of all runs; zeros are left out."""
    levels = {n: max(float(np.quantile(np.abs(run.recording[n]), 0.999)) for run in runs) for n in names}
    return {n: level for n, level in levels.items() if level > 0}


def _ranges(found: Fit) -> dict[str, tuple[float, float]]:
    """The ranges of the states in the runs, without those that stay constant."""
    model: Any = found.model
    every = [model.ranges_of_states(run, found.of_run(index)) for index, run in enumerate(found.runs)]
    ranges = {n: (min(r[n][0] for r in every), max(r[n][1] for r in every)) for n in every[0]}
    return {n: (low, high) for n, (low, high) in ranges.items() if high > low}
