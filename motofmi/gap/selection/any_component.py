"""Model selection on any component: initial fit of the base, noise estimate, and the effects at its own elements.

Without other information the noise is what a flexible model leaves of the best fit so far (see `flexible_noise_model`). So
model selection is repeated with the noise of its result until the noise changes little. Where no model leaves noise
alone, which is the rule on real machines, models are compared on blocks of their residuals instead (`comparison`).
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
from motofmi.gap.estimation.candidate import adequate, knows_its_noise
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

ROUNDS = 3  # of model selection with updated noise
FAST = 1.5  # factor on the estimate of white noise, which filtered sensors underestimate
# prior standard deviation of a sensor offset over the input's rms; unmodelled offsets of 0.03 and
# 0.1 gave wrong effects
OFFSET = 0.3
STEADY = 0.1  # relative change of the noise below which model selection is not repeated


@dataclass(frozen=True)
class Investigation:
    """The verdict, with the scaled experiment.

    factor is the common factor of fitted over initial values (see `common_factor`); unless it is 1 nothing is named.
    missed is the share of the measured motion that the best model misses; beyond `slow_noise_share` it is not called
    noise. kept are inertias that are not identifiable beside a stiffness in these runs, and that keep their values.
    """

    verdict: Verdict
    experiment: InputOutputExperiment
    factor: float = 1.0
    missed: float = 0.0
    kept: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"Investigation({self.verdict!r}, {self.missed:.1%} of the motion missed)"


def investigate(experiment: InputOutputExperiment, runs: Sequence[SampledRun], more_effects: Sequence[type[Effect]] = (), given: Mapping[str, float] | None = None,
                so_far: Callable[[Verdict], None] = lambda verdict: None, validation: Sequence[Recording] = (),
                library: Sequence[type[Effect]] = (), criteria: Criteria = Criteria()) -> Investigation:  # fmt: skip
    """The verdict on runs of a component, with the laws of mechanics at its elements (or a
    library) and further effects.

    given holds the known noise of outputs (standard deviation by name); so_far is called with an intermediate verdict
    at every stage; validation recordings can only reject a name. Raises InputError where the base cannot be fitted.
    """
    experiment = experiment.with_sensor_offsets(_offset_priors(runs))
    component, model = experiment.component, FreeInitialStateModel(experiment)
    found = initial_fit(model, runs)
    kept = inseparable_inertias(found, criteria)
    if kept and len(kept) < len(experiment.free):
        experiment = replace(experiment, free=tuple(f for f in experiment.free if f.name not in kept))
        model = FreeInitialStateModel(experiment)
        found = initial_fit(model, [replace(run, experiment=experiment, guess={}) for run in runs])
    found = fit(model, equal_noise(found.runs, found), found.x)
    deflection, rate = largest_motion(found)
    experiment = replace(experiment, component=experiment.component.with_values(**_values(found))).scaled(
        deflection, rate
    )
    library = [
        *(
            library
            or laws_at(
                experiment.component, rate, _largest(runs, experiment.driven), _largest(runs, experiment.outputs)
            )
        ),
        *more_effects,
    ]
    model = FreeInitialStateModel(experiment)
    base = fit(model, [_between_samples(model, run) for run in known_noise(found.runs, given or {})], model.start())
    verdict = Verdict("unknown", base, base, criteria=criteria)
    so_far(verdict)
    held = [prepare_sampled_run(r, experiment) for r in validation]
    verdict = _selected(base, library, held, so_far, criteria)
    expected = experiment.own_values and excited(runs)
    factor = common_factor(component, _values(verdict.best), criteria) if expected else 1.0
    if factor != 1.0 and verdict.verdict != "none":
        verdict = replace(verdict, verdict="unknown", effects=[], tied=[], unspecified_form=False)
    missed = _missed(verdict.best)
    if missed > criteria.slow_noise_share and verdict.verdict == "none" and verdict.comparison is None:
        verdict = replace(verdict, verdict="unknown")
    return Investigation(verdict, experiment, factor, missed, tuple(kept))


def _selected(base: Fit, library: Sequence[type[Effect]], held: Sequence[SampledRun], so_far: Callable[[Verdict], None],
              criteria: Criteria) -> Verdict:  # fmt: skip
    """The verdict by chi-square where the noise is known or some model leaves nothing else; by comparison otherwise."""
    if knows_its_noise(base):
        return _by_chi_square(base, library, held, so_far, criteria)
    singles = single_effects(base, library, criteria)
    best = min((c.fit for c in singles), key=lambda found: found.chi2, default=base)
    tried = _leaves_noise(best, held, criteria)
    if tried:
        verdict = _by_chi_square(base, library, held, so_far, criteria)
        if _settled(verdict, criteria):
            return verdict
    base = fit(base.model, [_in_shorter_segments(run) for run in base.runs], base.x)
    singles = single_effects(base, library, criteria)
    like = [_in_shorter_segments(run) for run in _with_noise_like(held, base.runs[0])]

    def said() -> None:
        so_far(Verdict("unknown", base, base, candidates=list(singles), criteria=criteria))

    compared = compare(base, singles, library, like, criteria, said)
    pairs = [c.fit for c in compared.contenders if len(c.effects) > 1] if compared else []
    if not tried and any(_leaves_noise(found, held, criteria) for found in pairs):
        verdict = _by_chi_square(base, library, held, so_far, criteria)
        tried = True
        if _settled(verdict, criteria):
            return verdict
    if compared is not None:
        return verdict_by_comparison(compared, singles, like, criteria)
    return verdict if tried else _by_chi_square(base, library, held, so_far, criteria)


def _in_shorter_segments(run: SampledRun) -> SampledRun:
    """The run in segments half as long: an incomplete model loses the phase of a large motion over long ones."""
    longest = max(last - first for first, last in run.segments)
    return run.cut(max(longest // 2, SHORTEST_SEGMENT))


def _settled(verdict: Verdict, criteria: Criteria) -> bool:
    """Whether chi-square decides: the form is specified, and validation runs are not far from the noise."""
    seen = verdict.validation_gap
    return not verdict.unspecified_form and (seen is None or seen[1].chi2 < criteria.far_from_noise)


def _leaves_noise(found: Fit, held: Sequence[SampledRun], criteria: Criteria) -> bool:
    """Whether what a fit leaves is consistent with what a flexible model leaves of it, and not far from it on
    validation runs."""
    try:
        quiet = _with_remaining_noise(found)
        if not adequate(fit(found.model, quiet, found.x, iterations=0), criteria):
            return False
        like = _with_noise_like(held, quiet[0])
        return not like or on_validation_runs(found, like, criteria).chi2 < criteria.far_from_noise
    except InputError:
        return False


def _by_chi_square(base: Fit, library: Sequence[type[Effect]], held: Sequence[SampledRun], so_far: Callable[[Verdict], None],
                   criteria: Criteria) -> Verdict:  # fmt: skip
    """The verdict of model selection, repeated with the noise of its result until the noise changes little."""
    verdict, known = Verdict("unknown", base, base, criteria=criteria), list[Fit]()
    prepared = _with_noise_of_best_effect(base, library, known, criteria)
    for first in (True, *(False,) * (ROUNDS - 1)):
        try:
            verdict = select_model(
                base.model,
                prepared,
                library,
                _with_noise_like(held, prepared[0]),
                so_far if first else _report_nothing,
                known,
                criteria,
            )  # a later round knows less while it lasts
        except InputError:  # the last best fit cannot be simulated with less noise: its verdict stands
            break
        so_far(verdict)
        known.append(verdict.best)
        before, prepared = prepared, list(verdict.best.runs)
        if _change(before, prepared) < STEADY:
            break
    if verdict.verdict == "named" and _doubtful(verdict, library, bool(held), criteria):
        return replace(verdict, verdict="unknown", effects=[], tied=[], unspecified_form=False)
    return verdict


def _report_nothing(verdict: Verdict) -> None:
    """For callers that need no intermediate verdicts."""


def _with_noise_like(held: Sequence[SampledRun], fitted: SampledRun) -> list[SampledRun]:
    """Validation runs with the noise and the input interpolation of a fitted run."""
    return [run.with_interpolation(fitted.kind).with_densities(fitted.densities, fitted.noise_source) for run in held]


def _between_samples(model: FreeInitialStateModel, run: SampledRun) -> SampledRun:
    """The run with the uncertainty of its inputs between their samples as additional variance."""
    if run.kind != KINDS[0]:
        return run
    one, other = (model.reduced(r, model.start())[0] for r in (run, run.with_interpolation(SMOOTHER)))
    return run.with_input_variance((one - other) * run.deviation)


def _with_noise_of_best_effect(
    base: Fit, library: Sequence[type[Effect]], known: list[Fit], criteria: Criteria = Criteria()
) -> list[SampledRun]:
    """The runs with the noise that the best single effect leaves: the residuals of a poor base are not noise.

    The fits are added to `known`.
    """
    for candidate in search_candidates(base, library, known=known, criteria=criteria):
        with suppress(InputError):  # this candidate cannot be simulated again
            return _with_remaining_noise(candidate.fit)
    return _with_remaining_noise(base)


def _with_remaining_noise(found: Fit) -> list[SampledRun]:
    """The runs of a fit with the noise estimated from its residuals."""
    return [found.model.with_remaining_noise(run, found.of_run(i)) for i, run in enumerate(found.runs)]


def _values(found: Fit) -> dict[str, float]:
    model: Any = found.model
    values = model.values(found.shared)
    return {
        n: float(np.clip(values[n], found.model.component.table[n].min, found.model.component.table[n].max))
        for n in found.model.base
    }


def largest_motion(found: Fit) -> tuple[float, float]:
    """The 99.9 % quantiles of deflection and rate of the component's first element in the runs."""
    sizes = []
    model: Any = found.model
    for index, run in enumerate(found.runs):
        _, deflections, rates, _ = model.residuals_and_motion(run, found.of_run(index))
        if deflections:
            sizes.append((np.quantile(np.abs(deflections[0]), 0.999), np.quantile(np.abs(rates[0]), 0.999)))
    return tuple(float(max(s)) for s in zip(*sizes, strict=True)) if sizes else (1.0, 1.0)  # type: ignore[return-value]


def _largest(runs: Sequence[SampledRun], names: Sequence[str]) -> dict[str, float]:
    """The 99.9 % quantiles of recorded signals, without those that are zero."""
    levels = {n: max(float(np.quantile(np.abs(run.recording[n]), 0.999)) for run in runs) for n in names}
    return {n: level for n, level in levels.items() if level > 0}


def _offset_priors(runs: Sequence[SampledRun]) -> dict[str, float]:
    """The prior standard deviation of each input's sensor offset."""
    rms = {n: max(float(np.std(run.recording[n])) for run in runs) for n in runs[0].experiment.inputs}
    return {n: OFFSET * deviation for n, deviation in rms.items() if deviation > 0}


def _doubtful(verdict: Verdict, library: Sequence[type[Effect]], confirmed: bool, criteria: Criteria) -> bool:
    """Whether a name is far from the noise without a validation run, or of unspecified form in a
    family with a single form.

    Such a family is an additional body, which reduces most kinds of misfit.
    """
    forms = sum(effect.family == verdict.effects[0].family for effect in library)
    return (verdict.best.reduced > criteria.far_from_noise and not confirmed) or (
        verdict.unspecified_form and forms == 1
    )


def _missed(found: Fit) -> float:
    """The largest share of an output (rms) that the model misses beyond fast noise."""
    model: Any = found.model
    shares = []
    for index, run in enumerate(found.runs):
        left = np.std(model.residuals_and_motion(run, found.of_run(index))[0], axis=0)
        noise = np.array([white_noise(y) for y in run.measured.T])
        shares += list(np.sqrt(np.maximum(left**2 - (FAST * noise) ** 2, 0.0)) / np.std(run.measured, axis=0))
    return float(max(shares))


def _change(before: Sequence[SampledRun], after: Sequence[SampledRun]) -> float:
    """The mean relative change of the standard deviations over the cosines."""
    return max(float(np.mean(np.abs(np.log(b.deviation / a.deviation)))) for a, b in zip(before, after, strict=True))
