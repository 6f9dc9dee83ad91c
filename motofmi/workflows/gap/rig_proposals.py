"""The runs that the steer test could make next, and what each would tell: sweeps of rider and bar, with a gyro, and of the bar alone."""

from dataclasses import dataclass, replace

import numpy as np

from identification.excitation import sweep
from identification.gap.data.runs import Run
from identification.gap.naming.fitted import Fit
from identification.gap.proposing.expected import Foresight
from identification.gap.proposing.next_test import Proposal, Sweep, further_sweeps
from identification.gap.proposing.planned import Channels, planned
from scenarios.rig_test import DAMPING, GYRO, STIFFNESS, bare_bar


@dataclass
class BareBar:
    """A sweep of the handlebar, hands off: the torque then holds the bar alone, with what sits on it."""

    settings: dict[str, float]
    errors: np.ndarray  # of inertia, damping and stiffness of the bar
    experiment: str = "bare_bar"
    sentence: str = "Sweep the bare handlebar, hands off: its torque holds inertia, springs and dampers of the bar alone."

    @classmethod
    def after(cls, found: Fit, duration: float = 60.0) -> "BareBar":
        """The sweep with frequencies and amplitude of the first run."""
        made: Run = found.runs[0]
        frequencies = [c.frequency for c in made.reduction.columns if c.order == 1]
        settings = {"from": float(min(frequencies)), "to": float(max(frequencies)), "duration": duration,
                    "amplitude": float(np.abs(made.moved(made.recording.time)[0]).max())}  # fmt: skip
        inertia = float(np.exp(found.x[0]))
        columns = found.model.stand.columns
        motion = sweep(settings["from"], settings["to"], duration, settings["amplitude"])
        run = planned(motion, replace(Channels.of(made, columns["imposed"]), further={}), columns, lambda run: inertia * run.moved(run.recording.time)[2][:, None])
        return cls(settings, bare_bar([run])[1])

    def foresee(self, rival: Fit) -> Foresight:
        """Inertia, damping and stiffness that a fit gives the bar, over the errors with which they would be known."""
        names = rival.model.names
        inertia = float(np.exp(rival.x[0]))
        predicted, slopes = np.zeros(3), np.zeros((3, len(names)))
        predicted[0], slopes[0, 0] = inertia / self.errors[0], inertia / self.errors[0]
        for row, name in ((1, DAMPING), (2, STIFFNESS)):
            if name in names:
                place = names.index(name)
                predicted[row], slopes[row, place] = rival.x[place] / self.errors[row], 1 / self.errors[row]
        return Foresight(predicted, slopes)

    def left(self, truth: Fit, rival: Fit) -> float:
        return np.inf


def rig_proposals(found: Fit) -> list[Proposal]:
    """What the rig could be asked next, after what a fit rests on."""
    return [BareBar.after(found), *_with_a_gyro(found), *further_sweeps(found)]


def _with_a_gyro(found: Fit) -> list[Proposal]:
    sensor = found.model.stand.further[GYRO]
    if any(output.column == GYRO for run in found.runs for output in run.outputs):
        return []
    sentence = "Repeat the sweep with a rate gyro on the torso: what the torso does parts its coupling with the bar from springs and dampers of the bar."
    return [Sweep.like(found, "torso_gyro", sentence, further={GYRO: sensor.noise})]
