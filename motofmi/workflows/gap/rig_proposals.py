"""Proposals for the next run of a steer test: sweeps of rider and handlebar, with a torso gyro, of the bar alone."""

from dataclasses import dataclass, replace

import numpy as np

from motofmi.frequency_response.excitation import sweep
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.experiment_design.discrimination import Prediction
from motofmi.gap.experiment_design.next_experiment import Proposal, Sweep, further_sweeps
from motofmi.gap.experiment_design.planned_run import Channels, planned
from motofmi.gap.preprocessing.steer_test_run import SteerTestRun
from motofmi.recordings.channels import TORSO_RATE
from motofmi.workflows.gap.rig import DAMPING, STIFFNESS, bare_bar


@dataclass
class BareBar:
    """A sweep of the handlebar without a rider, in which the torque is that of the bar and of parts fixed to it.

    errors (3,) are the expected standard errors of inertia, damping and stiffness of the bar.
    """

    settings: dict[str, float]
    errors: np.ndarray
    experiment: str = "bare_bar"
    sentence: str = (
        "Sweep the handlebar without a rider: the torque then shows inertia, stiffness and damping of the bar alone."
    )

    @classmethod
    def after(cls, found: Fit, duration: float = 60.0) -> "BareBar":
        """The sweep with frequencies and amplitude of the first run."""
        first: SteerTestRun = found.runs[0]
        frequencies = [c.frequency for c in first.reduction.columns if c.order == 1]
        settings = {"from": float(min(frequencies)), "to": float(max(frequencies)), "duration": duration,
                    "amplitude": float(np.abs(first.motion_at(first.recording.time)[0]).max())}  # fmt: skip
        inertia = float(np.exp(found.x[0]))
        columns = found.model.experiment.columns
        motion = sweep(settings["from"], settings["to"], duration, settings["amplitude"])
        run = planned(
            motion,
            replace(Channels.of(first, columns["imposed"]), further={}),
            columns,
            lambda run: inertia * run.motion_at(run.recording.time)[2][:, None],
        )
        return cls(settings, bare_bar([run])[1])

    def predict(self, rival: Fit) -> Prediction:
        """Inertia, damping and stiffness of the bar by a fit, divided by their expected errors."""
        names = rival.model.names
        inertia = float(np.exp(rival.x[0]))
        predicted, slopes = np.zeros(3), np.zeros((3, len(names)))
        predicted[0], slopes[0, 0] = inertia / self.errors[0], inertia / self.errors[0]
        for row, name in ((1, DAMPING), (2, STIFFNESS)):
            if name in names:
                place = names.index(name)
                predicted[row], slopes[row, place] = rival.x[place] / self.errors[row], 1 / self.errors[row]
        return Prediction(predicted, slopes)

    def left(self, truth: Fit, rival: Fit, enough: float) -> float:
        return np.inf


def rig_proposals(found: Fit) -> list[Proposal]:
    """The runs that could follow those of a fit."""
    return [BareBar.after(found), *_with_a_gyro(found), *further_sweeps(found)]


def _with_a_gyro(found: Fit) -> list[Proposal]:
    sensor = found.model.experiment.further[TORSO_RATE]
    if any(output.column == TORSO_RATE for run in found.runs for output in run.outputs):
        return []
    sentence = (
        "Repeat the sweep with a rate gyro on the torso: the torso's motion distinguishes its coupling with the "
        "handlebar from springs and dampers of the handlebar."
    )
    return [Sweep.like(found, "torso_gyro", sentence, further={TORSO_RATE: sensor.noise})]
