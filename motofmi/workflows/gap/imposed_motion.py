"""The steer test on the rig: handlebar and rider, steer angle imposed, torque measured.

Model and measurement are compared on the harmonics of a swept or stepped sine.
"""

from collections.abc import Callable, Sequence
from typing import Any

from fmus.declaration.component import Component
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.experiment_design.next_experiment import next_experiment
from motofmi.gap.experiments.experiment import ImposedMotionExperiment
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.steer_test_run import SteerTestRun, prepare_steer_test_run, require_unclipped
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.selection.result import Verdict
from motofmi.gap.verdict import as_result
from motofmi.recordings.recording import Recording
from motofmi.reports.gap_report import Pictures
from motofmi.reports.gap_rig import pictures
from motofmi.reports.gap_tables import modes_over_speed
from motofmi.reports.report import Section
from motofmi.workflows.gap.augmented_rider import effect_on_modes, fitted_rider, motion_of, rider_of
from motofmi.workflows.gap.fitted_model import FittedModel
from motofmi.workflows.gap.given import Given
from motofmi.workflows.gap.kind import Kind
from motofmi.workflows.gap.rig import rig_effects, rig_experiment, with_bare_bar
from motofmi.workflows.gap.rig_proposals import rig_proposals

UNVALIDATED = "No validation run: the verdict is not checked on data that were not used."
BAR_UNKNOWN = (
    "The handlebar's own inertia is not known (no rig.json, no run of the bare handlebar): an added inertia is not "
    "identifiable from these data."
)


class OnRig(Kind):
    """A rider on the rig, under any imposed motion."""

    title = "The gap between model and recordings"

    @classmethod
    def suits(cls, given: Given) -> bool:
        return given.vehicle is None and given.component is None

    def __init__(self, given: Given) -> None:
        if given.holds_eigenvalues:
            raise InputError(
                f"{given.recordings[0]} holds eigenvalues over speed, which need the vehicle: give vehicle, as in "
                "--vehicle sharp_1971"
            )
        self.given, self.rig = given, given.rig_contents
        self.experiment, self.library = rig_experiment(self.rig, given.rider), rig_effects(given.own_effects)
        if given.bare:
            self.experiment = with_bare_bar(self.experiment, prepared(given.runs("bare"), self.experiment))

    def bar_unknown(self) -> list[str]:
        """The limitation that applies if the handlebar's own inertia is not known."""
        return [] if "handlebar_inertia" in self.rig or self.given.bare else [BAR_UNKNOWN]

    def model(self, verdict: Verdict) -> FittedModel:
        source = f"Fitted to {', '.join(r.name for r in verdict.best.runs)}"
        return fitted_rider(verdict.best, source, self.given.effects_folder, self.given.own_effects)

    def modes_section(self, contents: dict[str, Any]) -> Section:
        return modes_over_speed(contents)


class SteerTest(OnRig):
    """A steer test with a swept or stepped sine. Raises NotSweptError for any other motion."""

    def __init__(self, given: Given) -> None:
        super().__init__(given)
        recordings, validation = (given.runs(use) for use in ("recordings", "validation"))
        runs = prepared([*recordings, *validation], self.experiment)
        self.runs, self.validation = runs[: len(recordings)], runs[len(recordings) :]

    def verdict(self, on_progress: Callable[[Verdict], None]) -> Verdict:
        return select_model(
            HarmonicModel(self.experiment),
            self.runs,
            self.library,
            self.validation,
            on_progress,
            criteria=self.given.criteria,
        )

    def contents(self, verdict: Verdict) -> dict[str, Any]:
        return as_result(verdict, "N.m")

    def limitations(self, verdict: Verdict, contents: dict[str, Any]) -> list[str]:
        every = (*self.runs, *self.validation)
        sentences = list(dict.fromkeys(note for r in every for note in (*r.notes, *r.recording.warnings)))
        return [*sentences, *self.bar_unknown(), *([] if self.validation else [UNVALIDATED])]

    def next_experiment(self, verdict: Verdict) -> dict[str, Any] | None:
        return next_experiment(verdict, rig_proposals)

    def modes(self, verdict: Verdict, model: Component) -> dict[str, Any] | None:
        if verdict.verdict != "named":
            return None
        return effect_on_modes(rider_of(verdict.base), model, motion_of(verdict.best, model))

    def pictures(self, verdict: Verdict) -> Pictures:
        return pictures(verdict)


def prepared(recordings: Sequence[Recording], experiment: ImposedMotionExperiment) -> list[SteerTestRun]:
    """The recordings reduced to the harmonics of their motion.

    Raises NotSweptError for a motion that is no swept or stepped sine, InputError for a recording that cannot be used.
    """
    require_unclipped(recordings)
    columns = experiment.columns
    return parallel_map(
        lambda r: prepare_steer_test_run(
            r, columns["imposed"], columns["measured"], columns["command"], tuple(experiment.further)
        ),
        recordings,
        "preparing runs",
    )
