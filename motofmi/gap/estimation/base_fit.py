"""The base of a component fitted to sampled runs."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.effects.stiffness import TurnedGravityTorque
from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate_laws import candidate_laws
from motofmi.gap.estimation.equation_error import EquationErrorFit, equation_error_fits
from motofmi.gap.estimation.fit_result import Fit, vector_of
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.from_rest import fit_from_rest
from motofmi.gap.estimation.initial_fit import equal_noise, initial_fit, stable_segments, with_best_interpolation
from motofmi.gap.estimation.sign_change import with_fitted_signs
from motofmi.gap.estimation.single_frequency import inseparable_inertias
from motofmi.gap.estimation.starting_values import within_bounds
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.input_interpolation import INTERPOLATIONS, SMOOTHER
from motofmi.gap.preprocessing.noise_sources import known_noise
from motofmi.gap.preprocessing.sampled_run import SampledRun

# Ratio of equation errors above which signs of stiffnesses are those before a change: without the sine of a pendulum
# that goes round, its stiffness may fit with the other sign.
CLEARLY_LESS = 3.0


@dataclass(frozen=True)
class FittedBase:
    """The base fitted in the scaled experiment, the candidate effects, sentences on laws that are no candidates, and
    the fits by equation error of base and effects."""

    fit: Fit
    candidates: list[type[Effect]]
    left_out: list[str]
    starts: list[EquationErrorFit]

    def __repr__(self) -> str:
        return f"FittedBase({self.fit!r}, {len(self.candidates)} candidates)"


def fitted_base(
    experiment: InputOutputExperiment,
    runs: Sequence[SampledRun],
    noise: Mapping[str, float],
    library: Sequence[type[Effect]],
    criteria: Criteria,
) -> FittedBase:
    """The base fitted from its initial fit.

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
    initial = fit_from_rest(initial) or initial
    signed = with_fitted_signs(initial, criteria)
    base = _with_candidates(signed, noise, library)
    if signed is not initial:
        before = _with_candidates(initial, noise, library)
        if experiment.imposed:
            base, before = (
                replace(b, starts=equation_error_fits(b.fit, [c for c in b.candidates if not _has_any_sign(c)]))
                for b in (base, before)
            )
        if base.starts and before.starts and CLEARLY_LESS * before.starts[0].chi2 < base.starts[0].chi2:
            base = before
    if base.starts and (stable := _on_stable_segments(base.fit, base.starts[0])) is not None:
        return replace(base, fit=_scaled(stable, largest_motion(stable), noise))
    return base


def _has_any_sign(law: type[Effect]) -> bool:
    """Whether a law fits beside a stiffness of either sign, and does not tell which one the base has."""
    return issubclass(law, TurnedGravityTorque)


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
    """Runs on segments over which the base and the model with the least equation error are stable."""
    runs = [_on_segments_of(base.model, base.x, run) for run in runs]
    if not starts:
        return runs
    model, x = starts[0].on(base)
    return [_on_segments_of(model, x, run) for run in runs]


def _on_segments_of(model: Any, x: np.ndarray, run: SampledRun) -> SampledRun:
    """The run itself where its segments are short enough for the model; else on shorter ones, in their band."""
    stable = stable_segments(model, x, run)
    return run if stable is run else stable.with_band_of_segments()


def _with_candidates(initial: Fit, noise: Mapping[str, float], library: Sequence[type[Effect]]) -> FittedBase:
    """The base fitted in the experiment that is scaled to the motion of a fit, with the candidate effects."""
    motion = largest_motion(initial)
    base = _scaled(initial, motion, noise)
    experiment: Any = base.model.experiment
    candidates, left_out = (list(library), []) if library else candidate_laws(experiment, initial)
    # Where the motion is imposed, the search itself is by equation error.
    starts = [] if experiment.imposed else equation_error_fits(base, candidates)
    return FittedBase(base, candidates, left_out, starts)


def _scaled(initial: Fit, motion: tuple[float, float], noise: Mapping[str, float]) -> Fit:
    """The base fitted again in the experiment that is scaled to the largest deflection and rate of a fit."""
    experiment = initial.model.experiment
    fitted_component = experiment.component.with_values(**fitted_values(initial))
    model = FreeInitialStateModel(replace(experiment, component=fitted_component).scaled(*motion))
    x = np.concatenate([model.start(), initial.x[len(model.names) :]])
    noisy = [
        _with_interpolation_error(model, run, vector_of(x, model, index))
        for index, run in enumerate(known_noise(initial.runs, noise))
    ]
    return fit(model, noisy, x)


def _with_interpolation_error(model: FreeInitialStateModel, run: SampledRun, q: np.ndarray) -> SampledRun:
    """The run with the additional variance due to inputs that are unknown between their samples.

    It is the squared difference of the model's outputs with two splines through the input, at the model's vector q.
    """
    if run.kind != INTERPOLATIONS[0]:
        return run
    smooth, smoother = (model.reduced(r, q)[0] for r in (run, run.with_interpolation(SMOOTHER)))
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
