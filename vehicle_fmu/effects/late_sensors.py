"""A sensor whose reading is delayed against the other sensors and the recorded inputs.

    y(t) = x(t - t_s)

A delay of all sensors is equivalent to an early motor, so that only delays of single sensors are candidates, one form
each.
"""

from typing import Any

from fmus import Effect, adds_to, parameter


class _LateSensor(Effect):
    delay = parameter("s", "Delay of the sensor", symbol="t_s", min=2e-3, max=0.3, start=0.02)

    def __init__(self, exact_delays: bool = False):
        super().__init__()  # the past of a true value is in no recording: always as states
        del exact_delays


def _of(sensor: str) -> type[Effect]:
    """The effect class of a sensor."""

    @adds_to(sensor)
    def shown(self: Effect, v: Any, m: Any) -> Any:
        return v.late - getattr(v, sensor)

    words = sensor.replace("_", " ")
    return type(f"Late{words.title().replace(' ', '')}", (_LateSensor,), {
        "__doc__": f"The sensor of the {words} is delayed.", "family": "channel_delay", "form": sensor,
        "delayed": {"late": (sensor, "delay")}, "shown": shown,
    })  # fmt: skip


LateRollRate, LateYawRate, LateSteerAngle, LateSteerRate, LateRollAngle = map(
    _of, ("roll_rate", "yaw_rate", "steer_angle", "steer_rate", "roll_angle")
)
