"""A steer motor whose torque differs from its command: by a gain or by a delay."""

from typing import ClassVar

from fmus import Effect, adds_to, parameter


class MotorGain(Effect):
    """The torque of the steer motor differs from its command by a constant factor."""

    family, form = "motor_gain", "ratio"
    ratio = parameter("1", "Relative excess of the torque over its command", symbol="r_m", min=-1, max=5, start=0.1)

    @adds_to("der(steer_rate)")
    def gives(self, v, m):
        return v.ratio * v.steer_torque


class MotorDelay(Effect):
    """The torque of the steer motor is delayed against its command."""

    family, form = "channel_delay", "motor"
    delay = parameter("s", "Delay of the motor's torque", symbol="t_m", min=0, max=0.3, start=0.0)
    lags = ("delay",)
    delayed: ClassVar = {"late_torque": ("steer_torque", "delay")}

    @adds_to("der(steer_rate)")
    def comes_late(self, v, m):
        return v.late_torque - v.steer_torque
