"""Laws between a component and the recording of an output, besides the gain of its sensor (see `sensor`).

    limit   clip(y, -L, L)
    lag     z,   tau z' = y - z
    drift   y + r (t / T - 1/2),   T the duration
"""

from typing import ClassVar

from fmus.declaration.variables import parameter, state
from fmus.effects.effect import Effect, adds_to
from fmus.effects.stiffness import beyond


class ClippedSensor(Effect):
    """The reading saturates: beyond a limit part of the measured quantity is lost."""

    part = "channel"
    family, form, element = "saturation", "clip", "output"
    share = parameter("1", "Share beyond the limit that is lost", symbol="s_y", min=0, max=1, start=0.5)
    limit = parameter("1", "Reading at the limit", symbol="L", min=1e-12, start=1.0)
    starts: ClassVar = {"limit": (0.3, 0.5, 0.7, 0.85)}
    relative_to_level: ClassVar = ("limit",)
    in_its_unit: ClassVar = ("limit",)

    @adds_to("force")
    def loss(self, v, m):
        return -v.share * beyond(v.deflection, v.limit, m)


class SensorLag(Effect):
    """The reading follows the measured quantity with a lag of first order."""

    part = "channel"
    family, form, element = "sensor_lag", "first_order", "output"
    share = parameter("1", "Share of the reading that lags", symbol="s", min=0, max=1, start=1.0)
    time_constant = parameter("s", "Time constant", symbol=r"\tau", min=1e-6, start=0.1)
    following = state("1", "Reading, delayed by the time constant", symbol="z")
    starts: ClassVar = {"time_constant": (0.03, 0.1, 0.3, 1.0)}
    relative_to_period: ClassVar = ("time_constant",)
    in_its_unit: ClassVar = ("following",)

    @adds_to("der(following)")
    def follow(self, v, m):
        return (v.deflection - v.following) / v.time_constant

    @adds_to("force")
    def delay(self, v, m):
        return v.share * (v.following - v.deflection)


class SensorDrift(Effect):
    """The zero of the sensor drifts steadily during the test."""

    part = "channel"
    family, form, element = "sensor_drift", "offset", "output"
    change = parameter("1", "Change of the zero over the duration", symbol="r", start=0.05)
    duration = parameter("s", "Duration of the test", symbol="T", min=1e-3, start=200.0, tunable=False)
    given: ClassVar = ("duration",)
    in_its_unit: ClassVar = ("change",)

    @adds_to("force")
    def drift(self, v, m):
        return v.change * (v.time / v.duration - 0.5)
