"""A sensor that shows what it measures later than the others do, and later than the inputs are recorded.

    y(t) = x(t - t_s)

All of them late together are the same as a motor that is early, so that only single ones are looked for: each is a form.
"""

from typing import Any

from fmus import Effect, adds_to, parameter


class _LateSensor(Effect):
    delay = parameter("s", "Delay of the sensor", symbol="t_s", min=2e-3, max=0.3, start=0.02)

    def __init__(self, exact_delays: bool = False):
        super().__init__()  # no recording has what a sensor measured earlier: always as states
        del exact_delays


def _of(sensor: str) -> type[Effect]:
    """The effect of that sensor."""

    @adds_to(sensor)
    def shown(self: Effect, v: Any, m: Any) -> Any:
        return v.late - getattr(v, sensor)

    words = sensor.replace("_", " ")
    return type(f"Late{words.title().replace(' ', '')}", (_LateSensor,), {
        "__doc__": f"The sensor of the {words} is late.", "family": "channel_delay", "form": sensor,
        "delayed": {"late": (sensor, "delay")}, "shown": shown,
    })  # fmt: skip


LateRollRate, LateYawRate, LateSteerAngle, LateSteerRate, LateRollAngle = map(_of, ("roll_rate", "yaw_rate", "steer_angle", "steer_rate", "roll_angle"))
