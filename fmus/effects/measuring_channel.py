"""Effects of the measuring channel: delays, clocks, shaft compliance, force sensors.

They belong to the test, not to the component.
"""

from typing import ClassVar

from fmus.declaration.variables import parameter
from fmus.effects.effect import Effect, adds_to


class ChannelDelay(Effect):
    """The output arrives later than the input."""

    family, form, part = "channel_delay", "delay", "channel"
    delay = parameter("s", "Delay of the output against the input", symbol="t_d", min=0, max=0.2, start=0.0)
    lags = ("delay",)


class ClockSkew(Effect):
    """The clocks of force and motion differ in rate: the delay of the force grows with time."""

    family, form, part = "channel_delay", "skew", "channel"
    skew = parameter(
        "1",
        "Growth of the delay of the force against the motion over time",
        symbol="s_d",
        min=-1e-3,
        max=1e-3,
        start=0.0,
    )
    lags = ("skew",)
    lag_grows = True


class GrowingDelay(Effect):
    """The delay of the force against the motion grows during the test, as with a buffer that fills."""

    family, form, part = "channel_delay", "growing", "channel"
    growth = parameter(
        "s",
        "Growth of the delay of the force against the motion over the duration",
        symbol="g_d",
        min=-0.2,
        max=0.2,
        start=0.0,
    )
    duration = parameter("s", "Duration of the test", symbol="T", min=1e-3, start=200.0, tunable=False)
    given = ("duration",)
    lags = ("growth",)
    lag_grows = True


class ShaftCompliance(Effect):
    """The shaft between servo and bar is compliant."""

    family, form, part = "shaft_compliance", "spring", "channel"
    compliance = parameter("rad/N.m", "Compliance between servo and bar", symbol="1/k_s", min=2e-6, max=1.0, start=1e-5)


class _Sensor(Effect):
    """The gain of the force sensor depends on the load."""

    part, element = "channel", "channel"
    reference = parameter("N.m", "Reference load", symbol="T_r", min=1e-12, start=100.0, tunable=False)
    given: ClassVar = ("reference",)
    in_its_unit: ClassVar = ("reference",)


class SensorNonlinearity(_Sensor):
    """The force sensor's gain changes with the square of the load."""

    family, form = "sensor_nonlinearity", "cubic"
    cubic_gain = parameter(
        "1", "Relative change of the gain at the reference load", symbol="g_3", min=-10, max=10, start=0.05
    )

    @adds_to("force")
    def reading(self, v, m):
        return v.cubic_gain * (v.force / v.reference) ** 2 * v.force


class OddSensor(_Sensor):
    """The force sensor's gain changes with the magnitude of the load."""

    family, form = "sensor_nonlinearity", "square"
    square_gain = parameter(
        "1",
        "Relative change of the gain at the reference load, the same to both sides",
        symbol="g_1",
        min=-10,
        max=10,
        start=0.05,
    )

    @adds_to("force")
    def reading(self, v, m):
        return v.square_gain * m.absolute(v.force / v.reference) * v.force


class UnevenSensor(_Sensor):
    """The force sensor's gain differs with the direction of the load."""

    family, form = "sensor_nonlinearity", "quadratic"
    quadratic_gain = parameter(
        "1",
        "Relative change of the gain at the reference load, odd in the load",
        symbol="g_2",
        min=-10,
        max=10,
        start=0.05,
    )

    @adds_to("force")
    def reading(self, v, m):
        return v.quadratic_gain * (v.force / v.reference) * v.force
