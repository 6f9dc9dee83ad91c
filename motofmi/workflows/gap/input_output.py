"""The gap of any component from recordings of its inputs and outputs, under any excitation."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from fmus.declaration.component import Component
from fmus.support.progress import say
from motofmi.gap.estimation.from_rest import are_step_responses
from motofmi.gap.estimation.unit_plausibility import parameters_with_force_or_mass
from motofmi.gap.experiment_design.next_experiment import next_experiment
from motofmi.gap.experiment_design.scaled_runs import scaled_runs
from motofmi.gap.experiments.input_output import InputOutputExperiment, input_output_experiment
from motofmi.gap.localisation.sampled_places import cells
from motofmi.gap.preprocessing.decimation import advice_on_rate
from motofmi.gap.preprocessing.recorded_rates import require_rates
from motofmi.gap.preprocessing.sampled_run import SampledRun, excited, move_both_ways
from motofmi.gap.preprocessing.sampled_run_preparation import FEWEST_SAMPLES, prepare_sampled_run
from motofmi.gap.preprocessing.springs_like_friction import without_springs_like_friction
from motofmi.gap.preprocessing.work_of_inputs import note_on_signs
from motofmi.gap.selection.any_component import Investigation, investigate
from motofmi.gap.selection.result import Verdict
from motofmi.gap.verdict import as_result
from motofmi.recordings.joined import with_short_joined
from motofmi.recordings.recording import Recording
from motofmi.reports.gap_component import modes_at_rest, pictures
from motofmi.reports.gap_report import Pictures
from motofmi.reports.report import Section
from motofmi.workflows.components import ships
from motofmi.workflows.gap.augmented_component import component_of, fitted_component, own_modes
from motofmi.workflows.gap.first_checks import (
    notes_on_degrees,
    notes_on_zeros,
    require_distinct,
    require_inputs,
    require_motion,
    require_start,
)
from motofmi.workflows.gap.fitted_model import FittedModel
from motofmi.workflows.gap.given import Given
from motofmi.workflows.gap.kind import Kind
from motofmi.workflows.gap.limitations import limitations_of, offset_like_friction

ANCHORED = (
    "No input is recorded, or all inputs are zero: only ratios of parameters are identifiable, with {} as given."
)
BOTH_WAYS = (
    "Every run, or every part of an imposed motion, moves one way, some forwards and some backwards: an offset of each "
    "would take the place of dry friction. An input, or the effort of an imposed motion, has one offset in all of them."
)


class InputOutput(Kind):
    """A component with recorded inputs and outputs, or with one of its states imposed."""

    title = "The gap between component and recordings"
    found: Investigation

    @classmethod
    def suits(cls, given: Given) -> bool:
        return given.component is not None

    def __init__(self, given: Given) -> None:
        self.given, self.component = given, given.tested
        quantities = {"time": "s"} | {n: row.unit for n, row in self.component.rows("input", "state", "output").items()}
        recordings, self.validation = (given.runs(use, quantities) for use in ("recordings", "validation"))
        every = [*recordings, *self.validation]
        require_distinct(recordings, self.validation)
        columns = _common_columns(every)
        unused = require_inputs(self.component, every, columns, given.impose)
        require_motion(self.component, every, columns, given.impose)
        require_rates(self.component, every, given.impose)
        experiment = replace(
            input_output_experiment(self.component, columns, given.impose, given.free),
            own_values=not ships(self.component),
        )
        require_start(self.component, given.impose)
        recordings, joined = with_short_joined(recordings, FEWEST_SAMPLES)
        self.validation, joined_validation = with_short_joined(self.validation, FEWEST_SAMPLES)
        runs = [prepare_sampled_run(r, experiment) for r in recordings]
        notes = [*(note for r in recordings for note in r.warnings), *(note for r in runs for note in r.notes)]
        notes += [f"{r.name}: {note}" for r in self.validation for note in r.warnings if note not in notes]
        self.signs = [note for r in (*recordings, *self.validation) for note in note_on_signs(experiment.component, r)]
        zeros = [] if ships(self.component) else notes_on_zeros(self.component, given.free)
        at_once = [*self.signs, *notes_on_degrees(self.component, every), *zeros, *filter(None, [advice_on_rate(runs)])]
        for sentence in at_once:
            say(sentence)
        self.notes = [*at_once, *joined, *joined_validation, *notes, *unused]
        if ships(self.component) and not given.free:  # its values are starting values and no expectation
            experiment, left_out = without_springs_like_friction(experiment, runs)
            self.notes += left_out
        if not (excited(runs) or are_step_responses(runs)):
            experiment, anchor = anchored(experiment)
            self.notes += [ANCHORED.format(anchor)] if anchor else []
        runs = [replace(run, experiment=experiment) for run in runs]
        self.notes += [BOTH_WAYS] if excited(runs) and move_both_ways(runs) else []
        self.experiment, self.runs, self.noise = experiment, runs, given.rig_contents.get("noise", {})

    def verdict(self, on_progress: Callable[[Verdict], None]) -> Verdict:
        self.found = investigate(
            self.experiment,
            self.runs,
            self.given.own_effects,
            self.noise,
            on_progress,
            self.validation,
            criteria=self.given.criteria,
        )
        if self.signs:  # with a force of the wrong sign no name applies
            self.found = replace(self.found, verdict=self.found.verdict.as_unknown())
        return self.found.verdict

    def contents(self, verdict: Verdict) -> dict[str, Any]:
        result = result_of(verdict, self.notes)
        if verdict.verdict == "none":  # friction of one direction may be taken for an offset
            result["reason"] = offset_like_friction(self.found)
        if self.signs:  # nor is any effect the nearest one
            result |= {"reason": self.signs[0], "closest": None, "alternatives": []}
        return result

    def limitations(self, verdict: Verdict, contents: dict[str, Any]) -> list[str]:
        return limitations_of(self.found, contents, self.component, bool(self.validation))

    def next_experiment(self, verdict: Verdict) -> dict[str, Any] | None:
        return next_experiment(verdict, scaled_runs)

    def model(self, verdict: Verdict) -> FittedModel:
        source = f"Fitted to {', '.join(r.name for r in verdict.best.runs)}"
        return fitted_component(self.found.experiment, verdict.best, source, self.given.own_class)

    def modes(self, verdict: Verdict, model: Component) -> dict[str, Any]:
        return {
            label: own_modes(component_of(self.found.experiment, each))
            for label, each in (("before", verdict.base), ("after", verdict.best))
        }

    def modes_section(self, contents: dict[str, Any]) -> Section | None:
        return modes_at_rest(contents) if "modes" in contents else None  # an interrupted search has no modes

    def pictures(self, verdict: Verdict) -> Pictures:
        return pictures(verdict)


def anchored(experiment: InputOutputExperiment) -> tuple[InputOutputExperiment, str]:
    """The experiment with one parameter fixed, and that parameter's name.

    Without an input only ratios of the parameters with force or mass in their unit are identifiable. One of them
    therefore keeps its value; unchanged if some of them are fixed already, or if there are none (name "").
    """
    free = [f.name for f in experiment.free]
    scaled = parameters_with_force_or_mass(experiment.component)
    fixed = [n for n in scaled if n not in free]
    if fixed or not scaled:
        return experiment, " and ".join(fixed)
    return replace(experiment, free=tuple(f for f in experiment.free if f.name != scaled[0])), scaled[0]


def _common_columns(recordings: Sequence[Recording]) -> list[str]:
    return [n for n in recordings[0].columns if all(n in r.columns for r in recordings)]


def result_of(verdict: Verdict, notes: Sequence[str]) -> dict[str, Any]:
    """The contents of `verdict.json` for a verdict on sampled runs; notes become limitations."""
    run: SampledRun = verdict.best.runs[0]
    unit = run.recording.units[run.experiment.outputs[0]]
    result = as_result(verdict, unit, run.noise_source or "flexible_model", cells)
    result["limitations"] = [*_said_once(notes, [r.name for r in verdict.best.runs]), *result["limitations"]]
    return result


def _said_once(notes: Sequence[str], runs: Sequence[str]) -> list[str]:
    """The notes, those of several runs that differ in the run's name alone as one."""
    names: dict[str, list[str]] = {}
    for note in dict.fromkeys(notes):
        run = next((n for n in runs if note.startswith(f"{n}: ")), "")
        names.setdefault(note.removeprefix(f"{run}: ") if run else note, []).append(run)
    return [f"{', '.join(of)}: {note}" if any(of) else note for note, of in names.items()]
