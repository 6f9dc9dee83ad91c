"""Model selection on any component: initial fit of the base, noise estimate, and the effects at its own elements."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fmus.declaration.units import is_inertia
from fmus.effects import Effect
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base, fitted_values, on_segments_like
from motofmi.gap.estimation.finite_equations import where_not_finite
from motofmi.gap.estimation.fit_result import Fit, parameters_of, undetermined
from motofmi.gap.estimation.from_rest import are_step_responses
from motofmi.gap.estimation.stages import Stage, running
from motofmi.gap.estimation.unit_plausibility import common_factor
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.sampled_run import SampledRun, excited, move_both_ways
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.chi_square_conditions import missed_share
from motofmi.gap.selection.noise_rounds import OnProgress
from motofmi.gap.selection.result import Verdict
from motofmi.gap.selection.staged_selection import Selection, undecided
from motofmi.gap.selection.within_time import within_time
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import varies

# Prior standard deviation of a sensor offset over the standard deviation of the input [1]. Offsets of 0.03 and 0.1 that
# were not modelled gave wrong effects.
OFFSET_PRIOR = 0.3
OTHER_UNIT = (
    "All parameters with force or mass in their unit were fitted to {:.3g} times their start values: is a column's unit "
    "wrong (deg for rad, kN for N, mm for m)? Nothing is named. If all units are right, give better start values: "
    "--component FILE.toml."
)
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
    experiment = with_unknown_offsets(experiment, runs)
    without_offsets = bool(experiment.imposed) and experiment.common_offsets
    runs = [replace(run, without_offsets=without_offsets) for run in runs]

    left_out: list[str] = []

    def search(report: OnProgress) -> Verdict:
        with running(Stage.BASE):
            with where_not_finite(experiment.component, runs):
                found = fitted_base(experiment, runs, given or {}, library, criteria)
            base, starts = found.fit, found.starts
            left_out.extend(found.left_out)
            prepared = [_prepared_for_validation(recording, base.model.experiment) for recording in validation]
            prepared = [replace(run, without_offsets=without_offsets) for run in prepared]
            validation_runs = on_segments_like(base, starts, prepared)
            report(undecided(base, validation_runs, criteria))
        library_of_base = [*found.candidates, *more_effects]
        return Selection(base, library_of_base, starts, validation_runs, report, criteria).verdict()

    verdict = within_time(search, on_progress)
    fitted: Any = verdict.best.model.experiment
    fixed = {f.name for f in experiment.free} - {f.name for f in fitted.free}
    expected = experiment.own_values and excited(runs)
    factor = common_factor(experiment.component, fitted_values(verdict.best), criteria) if expected else 1.0
    if factor != 1.0:
        other_unit = OTHER_UNIT.format(factor)
        none = verdict.verdict == "none"
        verdict = replace(verdict, withheld=other_unit) if none else verdict.as_unknown(other_unit)
    missed = missed_share(verdict.best)
    if missed > criteria.slow_noise_share and verdict.verdict == "none" and verdict.comparison is None:
        verdict = verdict.as_unknown(sentence_on_slow_noise(missed, experiment.outputs))
    if verdict.verdict in ("named", "tied") and (why := _unexplained_variance(verdict, experiment.outputs)):
        verdict = verdict.as_unknown(why)
    names = _values_if_none_is_determined(verdict.best, criteria)
    # An effect may take the place of a damping or a spring, but nothing that moves is without inertia.
    inertia = any(is_inertia(fitted.component.table[name].unit) for name in names)
    if names and (verdict.verdict == "none" or (verdict.verdict != "unknown" and inertia)):
        verdict = verdict.as_unknown(NOT_TESTED.format(" and ".join(names)))
    return Investigation(verdict, fitted, factor, missed, tuple(sorted(fixed)), tuple(left_out))


def sentence_on_slow_noise(missed: float, outputs: Sequence[str]) -> str:
    """The sentence on a share [1] of the recorded outputs that the best model misses, too much to be noise."""
    return (
        f"{100 * missed:.0f} % (rms) of the recorded {' or '.join(outputs)} in the fitted runs is not explained by the "
        "best model: too much to be called noise."
    )


def _unexplained_variance(verdict: Verdict, outputs: Sequence[str]) -> str:
    """The sentence where the best model leaves too much of the variance of an output for a name; empty otherwise."""
    compared = verdict.comparison.outcome.best if verdict.comparison else None
    fits = {"fitted": verdict.best, "validation": compared.validated if compared else None}
    missed = {runs: missed_share(found) for runs, found in fits.items() if found is not None}
    runs = max(missed, key=lambda each: missed[each])
    share, most = missed[runs] ** 2, verdict.criteria.unexplained_variance
    if share <= most:
        return ""
    return (
        f"No effect is named: {100 * share:.0f} % of the variance of the recorded {' or '.join(outputs)} in the {runs} "
        f"runs is not explained by the best model, more than {100 * most:.0f} %. Do the recorded inputs act on this "
        "component, and on nothing else?"
    )


def _prepared_for_validation(recording: Recording, experiment: Any) -> SampledRun:
    """A prepared validation run; one that does not begin at rest has free initial states, although the fitted runs are
    step responses."""
    run = prepare_sampled_run(recording, experiment)
    if experiment.from_rest and not are_step_responses([run]):
        return prepare_sampled_run(recording, replace(experiment, from_rest=False))
    return run


def _values_if_none_is_determined(found: Fit, criteria: Criteria) -> list[str]:
    """The parameters of the base, where all of them are within `Criteria.value_errors` standard errors of zero."""
    base = {name: value for name, value in parameters_of(found).items() if name in found.model.base}
    names = undetermined(base, criteria.value_errors)
    return names if len(names) == len(base) else []


def with_unknown_offsets(experiment: InputOutputExperiment, runs: Sequence[SampledRun]) -> InputOutputExperiment:
    """The experiment with unknown sensor offsets.

    Where every run moves one way, an offset of each run takes the place of dry friction. If runs in both directions show
    the friction, one offset is fitted in all runs, to each input or to the effort of an imposed motion.
    """
    both_ways = move_both_ways(runs)
    inputs = experiment.outputs if both_ways and experiment.imposed else experiment.inputs
    deviations = {n: [float(np.std(run.recording[n])) for run in runs if varies(run.recording[n])] for n in inputs}
    priors = {n: OFFSET_PRIOR * max(every) for n, every in deviations.items() if every}
    return experiment.with_sensor_offsets(priors, common=both_ways)
