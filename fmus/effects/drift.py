"""Stiffness and damping that change during a test: linearly, exponentially, or in a step."""

from typing import ClassVar

from fmus.declaration.variables import parameter
from fmus.effects.effect import Effect, adds_to

STEP_WIDTH = 5e-3  # as a share of the duration


class Drift(Effect):
    """Stiffness and damping change steadily during the test."""

    family, form, element = "drift", "both", "spring"
    ratio = parameter("1", "Relative change over the duration", symbol="r", min=-1, max=1, start=0.05)
    duration = parameter("s", "Duration of the test", symbol="T", min=1e-3, start=200.0, tunable=False)
    given = ("duration",)

    @adds_to("force")
    def change(self, v, m):
        return v.ratio * (v.time / v.duration - 0.5) * (v.stiffness * v.deflection + v.damping * v.rate)


class StiffnessDrift(Drift):
    """The stiffness changes steadily during the test."""

    form = "stiffness"

    @adds_to("force")
    def change(self, v, m):
        return v.ratio * (v.time / v.duration - 0.5) * v.stiffness * v.deflection


class DampingDrift(Drift):
    """The damping changes steadily during the test."""

    form = "damping"

    @adds_to("force")
    def change(self, v, m):
        return v.ratio * (v.time / v.duration - 0.5) * v.damping * v.rate


class SettlingDrift(Drift):
    """Stiffness and damping change fast at first and then settle, as during warm-up."""

    form = "settling"
    settling = parameter(
        "1", "Time constant of settling, as a share of the duration", symbol="t_s/T", min=0.02, max=3.0, start=0.25
    )
    starts: ClassVar = {"settling": (0.1, 0.3)}

    def settled(self, v, m):
        """The change as a share of the total change; its mean over the duration is zero, because the base includes
        the mean.
        """
        left = m.exp(-1 / v.settling)
        return (v.settling * (1 - left) - m.exp(-v.time / v.duration / v.settling)) / (1 - left)

    @adds_to("force")
    def change(self, v, m):
        return v.ratio * self.settled(v, m) * (v.stiffness * v.deflection + v.damping * v.rate)


class StiffnessSettling(SettlingDrift):
    """The stiffness changes fast at first and then settles."""

    form = "stiffness_settling"

    @adds_to("force")
    def change(self, v, m):
        return v.ratio * self.settled(v, m) * v.stiffness * v.deflection


class StepDrift(Drift):
    """Stiffness and damping change in a step during the test."""

    form = "step"
    moment = parameter(
        "1", "Time of the step, as a share of the duration", symbol="t_1/T", min=0.02, max=0.98, start=0.5
    )
    starts: ClassVar = {"moment": (0.2, 0.35, 0.5, 0.65, 0.8)}

    @adds_to("force")
    def change(self, v, m):
        after = m.tanh((v.time / v.duration - v.moment) / STEP_WIDTH) / 2
        return v.ratio * after * (v.stiffness * v.deflection + v.damping * v.rate)


class StiffnessStep(StepDrift):
    """The stiffness changes in a step during the test."""

    form = "stiffness_step"

    @adds_to("force")
    def change(self, v, m):
        return v.ratio * m.tanh((v.time / v.duration - v.moment) / STEP_WIDTH) / 2 * v.stiffness * v.deflection


class AnyDrift(Drift):
    """Stiffness and damping change during the test independently of each other."""

    form, flexible = "quadratic", True
    damping_ratio = parameter("1", "Relative change of the damping", symbol="r_c", min=-2, max=2, start=0.05)
    bend = parameter("1", "Quadratic part of the change of the stiffness", symbol="r_2", min=-2, max=2, start=0.05)

    @adds_to("force")
    def change(self, v, m):
        tau = v.time / v.duration - 0.5
        return (
            v.ratio * tau + v.bend * (tau**2 - 1 / 12)
        ) * v.stiffness * v.deflection + v.damping_ratio * tau * v.damping * v.rate
