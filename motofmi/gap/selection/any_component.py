"""Model selection on any component: initial fit of the base, noise estimate, and the effects at its own elements.

Where some model leaves only noise, models are selected by chi-square (`noise_rounds`). On real machines usually none
does; the models are then compared on blocks of their residuals (see the package `comparison`).
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.comparison.compare import Comparison, compare
from motofmi.gap.comparison.search import single_effects
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base, fitted_values, on_segments_like
from motofmi.gap.estimation.candidate import (
    Candidate,
    noise_is_known,
    ranked,
)
from motofmi.gap.estimation.equation_error import EquationErrorFit
from motofmi.gap.estimation.fit_result import Fit, parameters_of, undetermined
from motofmi.gap.estimation.fitting import fit, fit_or_none
from motofmi.gap.estimation.initial_fit import in_interpolation_of
from motofmi.gap.estimation.stages import Stage, running
from motofmi.gap.estimation.unit_plausibility import common_factor
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.sampled_run import SHORTEST_SEGMENT, SampledRun, excited, move_both_ways
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.by_comparison import in_units_of_residuals, verdict_by_comparison, with_remaining_noise
from motofmi.gap.selection.chi_square_conditions import (
    decisive,
    finds_a_law_outside,
    leaves_noise,
    missed_share,
    unless_doubtful,
    unless_sufficient,
    unless_unclear,
)
from motofmi.gap.selection.noise_rounds import OnProgress, select_in_rounds, with_noise_of
from motofmi.gap.selection.result import Verdict
from motofmi.gap.selection.within_time import within_time
from motofmi.gap.validation.before_after import before_and_after
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import varies

# Prior standard deviation of a sensor offset over the standard deviation of the input [1]. Offsets of 0.03 and 0.1 that
# were not modelled gave wrong effects.
OFFSET_PRIOR = 0.3
NOT_TESTED = (
    "These recordings do not test the model: none of its values is distinguishable from zero ({}). Set the parameter "
    "of an element that the component does not have to 0 in a value file: --component FILE.toml."
)


@dataclass(frozen=True)
class Investigation:
    """The verdict on a component, with the scaled experiment.

    factor [1] is the common factor of fitted over initial values (see `common_factor`); unless it is 1, no effect is
    named. missed [1] is the share (rms) of the measured motion that the best model does not reproduce; above
    `Criteria.slow_noise_share` this misfit is not regarded as noise. fixed_inertias are inertias that these runs do not
    distinguish from a stiffness; they keep their initial values. left_out are sentences on laws that are no candidates.
    """

    verdict: Verdict
    experiment: InputOutputExperiment
    factor: float = 1.0
    missed: float = 0.0
    fixed_inertias: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"Investigation({self.verdict!r}, {self.missed:.1%} of the motion missed)"


def investigate(
    experiment: InputOutputExperiment,
    runs: Sequence[SampledRun],
    more_effects: Sequence[type[Effect]] = (),
    given: Mapping[str, float] | None = None,
    on_progress: OnProgress = lambda verdict: None,
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
    experiment = experiment.with_sensor_offsets(offset_priors(runs))
    # An offset of the effort in each run would take the place of dry friction, see `offset_priors`.
    without_offsets = bool(experiment.imposed) and move_both_ways(runs)
    runs = [replace(run, without_offsets=without_offsets) for run in runs]

    left_out: list[str] = []

    def search(report: OnProgress) -> Verdict:
        with running(Stage.BASE):
            found = fitted_base(experiment, runs, given or {}, library, criteria)
            base, starts = found.fit, found.starts
            left_out.extend(found.left_out)
            prepared = [prepare_sampled_run(recording, base.model.experiment) for recording in validation]
            prepared = [replace(run, without_offsets=without_offsets) for run in prepared]
            validation_runs = on_segments_like(base, starts, prepared)
            report(_undecided(base, validation_runs, criteria))
        return _selected(base, [*found.candidates, *more_effects], starts, validation_runs, report, criteria)

    verdict = within_time(search, on_progress)
    fitted: Any = verdict.best.model.experiment
    fixed = {f.name for f in experiment.free} - {f.name for f in fitted.free}
    expected = experiment.own_values and excited(runs)
    factor = common_factor(experiment.component, fitted_values(verdict.best), criteria) if expected else 1.0
    if factor != 1.0 and verdict.verdict != "none":
        verdict = verdict.as_unknown()
    missed = missed_share(verdict.best)
    if missed > criteria.slow_noise_share and verdict.verdict == "none" and verdict.comparison is None:
        verdict = replace(verdict, verdict="unknown")
    if verdict.verdict == "none" and (names := _values_if_none_is_determined(verdict.best, criteria)):
        verdict = verdict.as_unknown(NOT_TESTED.format(" and ".join(names)))
    return Investigation(verdict, fitted, factor, missed, tuple(sorted(fixed)), tuple(left_out))


def _values_if_none_is_determined(found: Fit, criteria: Criteria) -> list[str]:
    """The parameters of the base, where all of them are within `Criteria.value_errors` standard errors of zero."""
    base = {name: value for name, value in parameters_of(found).items() if name in found.model.base}
    names = undetermined(base, criteria.value_errors)
    return names if len(names) == len(base) else []


def _undecided(
    base: Fit, validation_runs: Sequence[SampledRun], criteria: Criteria, singles: Sequence[Candidate] = ()
) -> Verdict:
    """The verdict before any decision, `unknown`; concluded, it has the noise of the best fit and its misfit on
    validation runs."""
    candidates = ranked(singles)
    verdict = Verdict(
        "unknown", base, candidates[0].fit if candidates else base, candidates=candidates, criteria=criteria
    )

    def conclude() -> Verdict:
        own, best = with_remaining_noise(verdict.base, verdict.best)
        checked = with_noise_of(best.runs[0], validation_runs)
        return replace(verdict, base=own, best=best, validation_gap=before_and_after(own, best, checked, criteria))

    return replace(verdict, conclude=conclude)


def _selected(
    base: Fit,
    library: Sequence[type[Effect]],
    starts: Sequence[EquationErrorFit],
    validation_runs: Sequence[SampledRun],
    on_progress: OnProgress,
    criteria: Criteria,
) -> Verdict:
    """The verdict by chi-square where the noise is known or some model leaves only noise; else by comparison."""
    if noise_is_known(base):
        known = _with_least_equation_error(base, starts)
        verdict = select_in_rounds(base, library, validation_runs, on_progress, criteria, known)
        return unless_doubtful(verdict, library, validation_runs, criteria)

    def confirmed(verdict: Verdict) -> Verdict:
        """The verdict by chi-square, where nothing is against it."""
        return unless_doubtful(unless_unclear(unless_sufficient(verdict)), library, validation_runs, criteria)

    def report_unknown(verdict: Verdict) -> None:
        """Noise that follows from the result is known at the end only: no name before."""
        conclude = verdict.conclude
        on_progress(replace(verdict.as_unknown(), conclude=conclude and (lambda: conclude().as_unknown())))

    def searched(base: Fit) -> tuple[Fit, list[SampledRun], Fit, list[Candidate]]:
        """The base and the validation runs in shorter segments, the best single effect, and all single effects."""
        shorter = fit(base.model, [in_shorter_segments(run) for run in base.runs], base.x)
        compared_runs = [in_shorter_segments(run) for run in with_noise_of(shorter.runs[0], validation_runs)]
        return shorter, compared_runs, *_single_effects(shorter, library, starts, compared_runs, on_progress, criteria)

    shorter, compared_runs, best, singles = searched(base)
    if (again := in_interpolation_of(best, base)) is not None:
        base = again
        shorter, compared_runs, best, singles = searched(base)
    with running(Stage.NOISE):
        continued = fit_or_none(best.model, base.runs, best.x)
        single, known = continued or best, [continued] if continued else []
        # The search by chi-square is over the longer segments, over which the best effect must be simulated.
        chi_square_tried = continued is not None and leaves_noise(continued, validation_runs, criteria)
    if chi_square_tried:
        verdict = select_in_rounds(base, library, validation_runs, report_unknown, criteria, known, continued)
        if decisive(verdict, single, continued is not None, criteria):
            return confirmed(verdict)
    shorter, singles, compared_runs = in_units_of_residuals(best, shorter, singles, compared_runs)

    def decided(compared: Comparison) -> Verdict:
        return verdict_by_comparison(compared, singles, compared_runs, criteria)

    def report(known: Callable[[], Comparison]) -> None:
        verdict = _undecided(shorter, compared_runs, criteria, singles)
        on_progress(replace(verdict, conclude=lambda: decided(known())))

    compared = compare(shorter, singles, library, compared_runs, criteria, report)
    pairs = [m.fit for m in compared.clear_pairs()] if compared else []
    pairs = [found for found in pairs if leaves_noise(found, validation_runs, criteria)]
    if not chi_square_tried and pairs:
        pair = fit_or_none(pairs[0].model, base.runs, pairs[0].x)
        known = [*([pair] if pair else []), *known]
        verdict = select_in_rounds(base, library, validation_runs, report_unknown, criteria, known, pair)
        chi_square_tried = True
        if decisive(verdict, single, continued is not None, criteria):
            return confirmed(verdict)
    if compared is not None:
        of_blocks = decided(compared)
        # What the search by chi-square withholds is not named by the comparison.
        named = chi_square_tried and of_blocks.verdict == "named" and finds_a_law_outside(verdict)
        return verdict if named else of_blocks
    if not chi_square_tried:
        verdict = select_in_rounds(base, library, validation_runs, report_unknown, criteria, known)
    return confirmed(verdict)


def _single_effects(
    base: Fit,
    library: Sequence[type[Effect]],
    starts: Sequence[EquationErrorFit],
    validation_runs: Sequence[SampledRun],
    on_progress: OnProgress,
    criteria: Criteria,
) -> tuple[Fit, list[Candidate]]:
    """The fit with the least chi-square, and all single effects that were fitted."""
    with running(Stage.SINGLE_EFFECTS):
        singles = single_effects(base, library, criteria, starts)
        best = min((c.fit for c in singles), key=lambda found: found.chi2, default=base)
        on_progress(_undecided(base, validation_runs, criteria, singles))
    return best, singles


def _with_least_equation_error(base: Fit, starts: Sequence[EquationErrorFit]) -> list[Fit]:
    """The effect with the least equation error, simulated with its values; none where it cannot be simulated, or the
    base alone has the least."""
    with suppress(InputError):
        if starts and starts[0].effect:
            model, x = starts[0].on(base)
            return [fit(model, base.runs, x, iterations=0)]
    return []


def in_shorter_segments(run: SampledRun) -> SampledRun:
    """The run in segments half as long: the phase error of an incomplete model grows with the length of a segment."""
    longest = max(last - first for first, last in run.segments)
    return run.cut(max(longest // 2, SHORTEST_SEGMENT))


def offset_priors(runs: Sequence[SampledRun]) -> dict[str, float]:
    """The prior standard deviation of each input's sensor offset, in the unit of the input.

    Where every run moves one way, an offset of each run takes the place of dry friction. There are none then, if runs
    in both directions show the friction.
    """
    if move_both_ways(runs):
        return {}
    inputs = runs[0].experiment.inputs
    deviations = {n: [float(np.std(run.recording[n])) for run in runs if varies(run.recording[n])] for n in inputs}
    return {n: OFFSET_PRIOR * max(every) for n, every in deviations.items() if every}
