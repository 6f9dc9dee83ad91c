"""The steer test with a motion that is no swept or stepped sine (multisine, random noise), compared over time."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from fmus.declaration.component import Component
from motofmi.gap.experiment_design.next_experiment import next_experiment
from motofmi.gap.experiment_design.scaled_runs import scaled_runs
from motofmi.gap.experiments.experiment import ImposedMotionExperiment
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.preprocessing.steer_test_run import require_unclipped
from motofmi.gap.selection.any_component import Investigation, investigate
from motofmi.gap.selection.result import Verdict
from motofmi.recordings.recording import Recording
from motofmi.reports.gap_component import pictures
from motofmi.reports.gap_report import Pictures
from motofmi.workflows.gap.augmented_rider import effect_on_modes, rider_of
from motofmi.workflows.gap.given import Given
from motofmi.workflows.gap.imposed_motion import OnRig
from motofmi.workflows.gap.input_output import result_of
from motofmi.workflows.gap.limitations import limitations_of

OVER_TIME = ("The imposed angle is no swept or stepped sine: the runs are compared over time, where the noise is not "
             "known separately. A sweep is more informative (motofmi gap --plan).")  # fmt: skip


class SteerTestOverTime(OnRig):
    """A steer test with any imposed motion."""

    found: Investigation

    def __init__(self, given: Given) -> None:
        super().__init__(given)
        on_rig = self.experiment
        self.sampled = InputOutputExperiment(on_rig.component, (on_rig.imposed,), (on_rig.measured,), on_rig.free,
                                             on_rig.imposed, measured_effects=on_rig.measured_effects)  # fmt: skip
        recordings, self.validation = (_renamed(given.runs(use), on_rig) for use in ("recordings", "validation"))
        self.runs = [prepare_sampled_run(r, self.sampled) for r in recordings]
        self.notes = [
            OVER_TIME,
            *(note for r in (*recordings, *self.validation) for note in r.warnings),
            *(note for r in self.runs for note in r.notes),
        ]

    def verdict(self, on_progress: Callable[[Verdict], None]) -> Verdict:
        self.found = investigate(self.sampled, self.runs, on_progress=on_progress, validation=self.validation,
                                 library=self.library, criteria=self.given.criteria)  # fmt: skip
        return self.found.verdict

    def contents(self, verdict: Verdict) -> dict[str, Any]:
        return result_of(verdict, self.notes)

    def limitations(self, verdict: Verdict, contents: dict[str, Any]) -> list[str]:
        return [
            *limitations_of(self.found, contents, self.experiment.component, bool(self.validation)),
            *self.bar_unknown(),
        ]

    def next_experiment(self, verdict: Verdict) -> dict[str, Any] | None:
        return next_experiment(verdict, scaled_runs)

    def modes(self, verdict: Verdict, model: Component) -> dict[str, Any] | None:
        return effect_on_modes(rider_of(verdict.base), model) if verdict.verdict == "named" else None

    def pictures(self, verdict: Verdict) -> Pictures:
        return pictures(verdict)


def _renamed(recordings: Sequence[Recording], experiment: ImposedMotionExperiment) -> list[Recording]:
    """The recordings with their columns renamed to the variables of the rig model."""
    require_unclipped(recordings)
    names = {experiment.columns["imposed"]: experiment.imposed, experiment.columns["measured"]: experiment.measured}
    return [
        replace(
            r,
            columns={new: r[old] for old, new in names.items()},
            units={new: r.units[old] for old, new in names.items()},
        )
        for r in recordings
    ]
