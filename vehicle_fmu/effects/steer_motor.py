"""A steer motor that does not give what it is told: another gain, or later."""

from typing import ClassVar

from fmus import Effect, adds_to, parameter


class MotorGain(Effect):
    """The steer motor gives another torque than it is told, in proportion."""

    family, form = "motor_gain", "ratio"
    ratio = parameter("1", "Torque beyond what is told, over that", symbol="r_m", min=-1, max=5, start=0.1)

    @adds_to("der(steer_rate)")
    def gives(self, v, m):
        return v.ratio * v.steer_torque


class MotorDelay(Effect):
    """The steer motor gives its torque later than it is told."""

    family, form = "channel_delay", "motor"
    delay = parameter("s", "Delay of the motor's torque", symbol="t_m", min=0, max=0.3, start=0.0)
    lags = ("delay",)
    delayed: ClassVar = {"late_torque": ("steer_torque", "delay")}

    @adds_to("der(steer_rate)")
    def comes_late(self, v, m):
        return v.late_torque - v.steer_torque
