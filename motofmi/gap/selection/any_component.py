"""Model selection on any component: initial fit of the base, noise estimate, and the effects at its own elements.

Without other information the noise is estimated as the residual of a flexible model, which is fitted to the residuals
of the best fit (see `flexible_noise_model`). A better fit leaves less noise, so model selection is repeated with the
noise of its result until the noise changes little. On real machines usually no model has residuals that are consistent
with noise; the models are then compared on blocks of their residuals (see the package `comparison`).
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.effects.placement import laws_at
from fmus.support.errors import InputError
from motofmi.gap.comparison.compare import compare
from motofmi.gap.comparison.search import single_effects
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import adequate, noise_is_known
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.initial_fit import equal_noise, initial_fit
from motofmi.gap.estimation.single_frequency import inseparable_inertias
from motofmi.gap.estimation.unit_plausibility import common_factor
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.input_interpolation import KINDS, SMOOTHER
from motofmi.gap.preprocessing.noise_sources import known_noise
from motofmi.gap.preprocessing.sampled_run import SHORTEST_SEGMENT, SampledRun, excited, prepare_sampled_run
from motofmi.gap.selection.by_comparison import verdict_by_comparison
from motofmi.gap.selection.candidate_search import search_candidates
from motofmi.gap.selection.model_selection import Verdict, select_model
from motofmi.gap.validation.before_after import on_validation_runs
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import white_noise

MOST_ROUNDS = 3  # rounds of model selection, each with the noise of the previous result
# Factor on the estimate of white noise [1]: that estimate uses differences of adjacent samples and is too small for
# sensors with a low-pass filter.
WHITE_NOISE_FACTOR = 1.5
# Prior standard deviation of a sensor offset over the standard deviation of the input [1]. Offsets of 0.03 and 0.1 that
# were not modelled gave wrong effects.
OFFSET_PRIOR = 0.3
NOISE_CHANGE = 0.1  # mean relative change of the noise's standard deviation below which there is no further round


@dataclass(frozen=True)
class Investigation:
    """The verdict on a component, with the scaled experiment.

    factor [1] is the common factor of fitted over initial values (see `common_factor`); unless it is 1, no effect is
    named. missed [1] is the share (rms) of the measured motion that the best model does not reproduce; above
    `Criteria.slow_noise_share` this misfit is not regarded as noise. fixed_inertias are inertias that these runs do not
    distinguish from a stiffness; they keep their initial values.
    """

    verdict: Verdict
    experiment: InputOutputExperiment
    factor: float = 1.0
    missed: float = 0.0
    fixed_inertias: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"Investigation({self.verdict!r}, {self.missed:.1%} of the motion missed)"


def investigate(
    experiment: InputOutputExperiment,
    runs: Sequence[SampledRun],
    more_effects: Sequence[type[Effect]] = (),
    given: Mapping[str, float] | None = None,
    on_progress: Callable[[Verdict], None] = lambda verdict: None,
    validation: Sequence[Recording] = (),
    library: Sequence[type[Effect]] = (),
    criteria: Criteria = Criteria(),
) -> Investigation:
    """The verdict on runs of a component.

    The candidates are the effects of `library`, or by default the laws at the places of the component, and
    `more_effects`. given holds the known standard deviation of the noise by output, each in the output's unit.
    on_progress is called with an intermediate verdict after every stage. A validation recording can reject an effect,
    it cannot add one. Raises InputError where the base cannot be fitted.
    """
    experiment = experiment.with_sensor_offsets(_offset_priors(runs))
    component, model = experiment.component, FreeInitialStateModel(experiment)
    initial = initial_fit(model, runs)
    fixed = inseparable_inertias(initial, criteria)
    if fixed and len(fixed) < len(experiment.free):
        experiment = replace(experiment, free=tuple(f for f in experiment.free if f.name not in fixed))
        model = FreeInitialStateModel(experiment)
        initial = initial_fit(model, [replace(run, experiment=experiment, guess={}) for run in runs])
    initial = fit(model, equal_noise(initial.runs, initial), initial.x)
    deflection, rate = largest_motion(initial)
    fitted_component = experiment.component.with_values(**_values(initial))
    experiment = replace(experiment, component=fitted_component).scaled(deflection, rate)
    inputs, outputs = _largest(runs, experiment.driven), _largest(runs, experiment.outputs)
    states = {} if experiment.imposed else _ranges(initial)
    period = float(np.median([1 / run.middle_frequency for run in runs]))
    library = [*(library or laws_at(experiment.component, rate, inputs, outputs, states, period)), *more_effects]
    model = FreeInitialStateModel(experiment)
    noisy = [_with_interpolation_error(model, run) for run in known_noise(initial.runs, given or {})]
    base = fit(model, noisy, model.start())
    verdict = Verdict("unknown", base, base, criteria=criteria)
    on_progress(verdict)
    validation_runs = [prepare_sampled_run(recording, experiment) for recording in validation]
    verdict = _selected(base, library, validation_runs, on_progress, criteria)
    expected = experiment.own_values and excited(runs)
    factor = common_factor(component, _values(verdict.best), criteria) if expected else 1.0
    if factor != 1.0 and verdict.verdict != "none":
        verdict = replace(verdict, verdict="unknown", effects=[], tied=[], unspecified_form=False)
    missed = _missed(verdict.best)
    if missed > criteria.slow_noise_share and verdict.verdict == "none" and verdict.comparison is None:
        verdict = replace(verdict, verdict="unknown")
    return Investigation(verdict, experiment, factor, missed, tuple(fixed))


def _selected(
    base: Fit,
    library: Sequence[type[Effect]],
    validation_runs: Sequence[SampledRun],
    on_progress: Callable[[Verdict], None],
    criteria: Criteria,
) -> Verdict:
    """The verdict by chi-square where the noise is known or some model leaves noise alone; else by comparison."""
    if noise_is_known(base):
        return _by_chi_square(base, library, validation_runs, on_progress, criteria)
    singles = single_effects(base, library, criteria)
    best = min((c.fit for c in singles), key=lambda found: found.chi2, default=base)
    chi_square_tried = _leaves_noise(best, validation_runs, criteria)
    if chi_square_tried:
        verdict = _by_chi_square(base, library, validation_runs, on_progress, criteria)
        if _decisive(verdict, criteria):
            return verdict
    base = fit(base.model, [_in_shorter_segments(run) for run in base.runs], base.x)
    singles = single_effects(base, library, criteria)
    compared_runs = [_in_shorter_segments(run) for run in _with_noise_of(base.runs[0], validation_runs)]

    def report_singles() -> None:
        on_progress(Verdict("unknown", base, base, candidates=list(singles), criteria=criteria))

    compared = compare(base, singles, library, compared_runs, criteria, report_singles)
    pairs = [c.fit for c in compared.models if len(c.effects) > 1] if compared else []
    if not chi_square_tried and any(_leaves_noise(found, validation_runs, criteria) for found in pairs):
        verdict = _by_chi_square(base, library, validation_runs, on_progress, criteria)
        chi_square_tried = True
        if _decisive(verdict, criteria):
            return verdict
    if compared is not None:
        return verdict_by_comparison(compared, singles, compared_runs, criteria)
    if chi_square_tried:
        return verdict
    return _by_chi_square(base, library, validation_runs, on_progress, criteria)


def _in_shorter_segments(run: SampledRun) -> SampledRun:
    """The run in segments half as long: the phase error of an incomplete model grows with the length of a segment."""
    longest = max(last - first for first, last in run.segments)
    return run.cut(max(longest // 2, SHORTEST_SEGMENT))


def _decisive(verdict: Verdict, criteria: Criteria) -> bool:
    """Whether the verdict by chi-square is final: its form is specified, and no validation run is far from the noise.

    Otherwise the models are compared on blocks.
    """
    gap = verdict.validation_gap
    return not verdict.unspecified_form and (gap is None or gap[1].chi2 < criteria.far_from_noise)


def _leaves_noise(found: Fit, validation_runs: Sequence[SampledRun], criteria: Criteria) -> bool:
    """Whether the residuals of a fit are consistent with the noise that a flexible model estimates from them.

    On validation runs the reduced chi-square must also be below `Criteria.far_from_noise`.
    """
    try:
        runs = _with_remaining_noise(found)
        if not adequate(fit(found.model, runs, found.x, iterations=0), criteria):
            return False
        checked = _with_noise_of(runs[0], validation_runs)
        return not checked or on_validation_runs(found, checked, criteria).chi2 < criteria.far_from_noise
    except InputError:
        return False


def _by_chi_square(
    base: Fit,
    library: Sequence[type[Effect]],
    validation_runs: Sequence[SampledRun],
    on_progress: Callable[[Verdict], None],
    criteria: Criteria,
) -> Verdict:
    """The verdict of model selection, repeated with the noise of its result until the noise changes little."""
    verdict, known = Verdict("unknown", base, base, criteria=criteria), list[Fit]()
    prepared = _with_noise_of_best_effect(base, library, known, criteria)
    for round_ in range(MOST_ROUNDS):
        checked = _with_noise_of(prepared[0], validation_runs)
        # Intermediate verdicts of a later round contain less than the final verdict of the round before.
        report = on_progress if round_ == 0 else _report_nothing
        try:
            verdict = select_model(base.model, prepared, library, checked, report, known, criteria)
        except InputError:  # no simulation of the last best fit with less noise: the verdict of the last round remains
            break
        on_progress(verdict)
        known.append(verdict.best)
        before, prepared = prepared, list(verdict.best.runs)
        if _change(before, prepared) < NOISE_CHANGE:
            break
    if verdict.verdict == "named" and _doubtful(verdict, library, bool(validation_runs), criteria):
        return replace(verdict, verdict="unknown", effects=[], tied=[], unspecified_form=False)
    return verdict


def _report_nothing(verdict: Verdict) -> None:
    """For callers that need no intermediate verdicts."""


def _with_noise_of(fitted: SampledRun, validation_runs: Sequence[SampledRun]) -> list[SampledRun]:
    """Validation runs with the noise and the input interpolation of a fitted run."""
    return [
        run.with_interpolation(fitted.kind).with_densities(fitted.densities, fitted.noise_source)
        for run in validation_runs
    ]


def _with_interpolation_error(model: FreeInitialStateModel, run: SampledRun) -> SampledRun:
    """The run with the additional variance due to inputs that are unknown between their samples.

    It is the squared difference of the model's outputs with two splines through the input.
    """
    if run.kind != KINDS[0]:
        return run
    smooth, smoother = (model.reduced(r, model.start())[0] for r in (run, run.with_interpolation(SMOOTHER)))
    return run.with_input_variance((smooth - smoother) * run.deviation)


def _with_noise_of_best_effect(
    base: Fit, library: Sequence[type[Effect]], known: list[Fit], criteria: Criteria = Criteria()
) -> list[SampledRun]:
    """The runs with the noise estimated from the best single effect; the residuals of a poor base are not noise.

    If that fit cannot be simulated again the next best one is used, at last the base. All fits are added to `known`.
    """
    for candidate in search_candidates(base, library, known=known, criteria=criteria):
        with suppress(InputError):
            return _with_remaining_noise(candidate.fit)
    return _with_remaining_noise(base)


def _with_remaining_noise(found: Fit) -> list[SampledRun]:
    """The runs of a fit with the noise estimated from its residuals."""
    return [found.model.with_remaining_noise(run, found.of_run(i)) for i, run in enumerate(found.runs)]


def _values(found: Fit) -> dict[str, float]:
    """The fitted parameters of the base by name, within their bounds."""
    model: Any = found.model
    values, rows = model.values(found.shared), model.component.table
    return {n: float(np.clip(values[n], rows[n].min, rows[n].max)) for n in model.base}


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


def _offset_priors(runs: Sequence[SampledRun]) -> dict[str, float]:
    """The prior standard deviation of each input's sensor offset, in the unit of the input."""
    inputs = runs[0].experiment.inputs
    deviations = {n: max(float(np.std(run.recording[n])) for run in runs) for n in inputs}
    return {n: OFFSET_PRIOR * deviation for n, deviation in deviations.items() if deviation > 0}


def _doubtful(verdict: Verdict, library: Sequence[type[Effect]], confirmed: bool, criteria: Criteria) -> bool:
    """Whether a named effect is withdrawn.

    It is where the residuals are far from the noise and no validation run confirms it, and where its form is
    unspecified in a family with a single form: such a family is an additional body, which reduces most kinds of misfit.
    """
    forms = sum(effect.family == verdict.effects[0].family for effect in library)
    unconfirmed = verdict.best.reduced > criteria.far_from_noise and not confirmed
    return unconfirmed or (verdict.unspecified_form and forms == 1)


def _missed(found: Fit) -> float:
    """The rms of the misfit of an output, without white noise, over the rms of the output [1]; the largest of all."""
    model: Any = found.model
    shares = []
    for index, run in enumerate(found.runs):
        misfit = np.std(model.residuals_and_motion(run, found.of_run(index))[0], axis=0)
        noise = WHITE_NOISE_FACTOR * np.array([white_noise(y) for y in run.measured.T])
        shares += list(np.sqrt(np.maximum(misfit**2 - noise**2, 0.0)) / np.std(run.measured, axis=0))
    return float(max(shares))


def _change(before: Sequence[SampledRun], after: Sequence[SampledRun]) -> float:
    """The mean relative change of the noise's standard deviation over all coefficients, the largest of all runs."""
    return max(float(np.mean(np.abs(np.log(b.deviation / a.deviation)))) for a, b in zip(before, after, strict=True))
