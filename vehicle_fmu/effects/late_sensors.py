"""A sensor that shows what it measures later than the others do, and later than the inputs are recorded.

All of them late together are the same as a motor that is early, so that only single ones are looked for: each is a form.
"""

from typing import ClassVar

from fmus import Effect, adds_to, parameter


class _LateSensor(Effect):
    """A sensor shows what it measures later than the others."""

    delay = parameter("s", "Delay of the sensor", symbol="t_s", min=2e-3, max=0.3, start=0.02)

    def __init__(self, exact_delays: bool = False):
        super().__init__()  # no recording has what a sensor measured earlier: always as states
        del exact_delays


class LateRollRate(_LateSensor):
    """The sensor of the roll rate is late."""

    family, form = "channel_delay", "roll_rate"
    delayed: ClassVar = {"late": ("roll_rate", "delay")}

    @adds_to("roll_rate")
    def shown(self, v, m):
        return v.late - v.roll_rate


class LateYawRate(_LateSensor):
    """The sensor of the yaw rate is late."""

    family, form = "channel_delay", "yaw_rate"
    delayed: ClassVar = {"late": ("yaw_rate", "delay")}

    @adds_to("yaw_rate")
    def shown(self, v, m):
        return v.late - v.yaw_rate


class LateSteerAngle(_LateSensor):
    """The sensor of the steer angle is late."""

    family, form = "channel_delay", "steer_angle"
    delayed: ClassVar = {"late": ("steer_angle", "delay")}

    @adds_to("steer_angle")
    def shown(self, v, m):
        return v.late - v.steer_angle


class LateSteerRate(_LateSensor):
    """The sensor of the steer rate is late."""

    family, form = "channel_delay", "steer_rate"
    delayed: ClassVar = {"late": ("steer_rate", "delay")}

    @adds_to("steer_rate")
    def shown(self, v, m):
        return v.late - v.steer_rate


class LateRollAngle(_LateSensor):
    """The sensor of the roll angle is late."""

    family, form = "channel_delay", "roll_angle"
    delayed: ClassVar = {"late": ("roll_angle", "delay")}

    @adds_to("roll_angle")
    def shown(self, v, m):
        return v.late - v.roll_angle
