"""Laws between a recorded input and the component: what acts differs from what was recorded.

    dead zone      u - clip(u, -w, w)
    square, cubic  u (1 + g u / r),   u (1 + g (u / r)^2),   r the largest input
    lag            z,   tau z' = u - z
    drift          u (1 + g (t / T - 1/2)),   T the duration
"""

from typing import ClassVar

from fmus.declaration.variables import parameter, state
from fmus.effects.effect import Effect, adds_to
from fmus.effects.stiffness import beyond


class DeadZone(Effect):
    """A small input has no effect: it acts by as much as it exceeds a threshold."""

    family, form, element = "dead_zone", "threshold", "input"
    half_width = parameter("1", "Input up to which nothing acts", symbol="w", min=0, start=0.1)
    starts: ClassVar = {"half_width": (0.1,)}
    relative_to_level: ClassVar = ("half_width",)
    in_its_unit: ClassVar = ("half_width",)

    @adds_to("force")
    def reduction(self, v, m):
        return beyond(v.deflection, v.half_width, m) - v.deflection


class CubicInput(Effect):
    """The gain of the input changes with its square."""

    family, form, element = "input_nonlinearity", "cubic", "input"
    cubic_gain = parameter(
        "1", "Relative change of the gain at the largest input", symbol="g_3", min=-0.33, max=10, start=0.05
    )
    reference = parameter("1", "Largest input", symbol="u_r", min=1e-12, start=1.0, tunable=False)
    given: ClassVar = ("reference",)
    relative_to_level: ClassVar = ("reference",)
    in_its_unit: ClassVar = ("reference",)

    @adds_to("force")
    def change(self, v, m):
        return v.cubic_gain * (v.deflection / v.reference) ** 2 * v.deflection


class SquareInput(Effect):
    """The gain of the input differs with its sign."""

    family, form, element = "input_nonlinearity", "quadratic", "input"
    quadratic_gain = parameter(
        "1", "Relative change of the gain at the largest input, odd in it", symbol="g_2", min=-0.5, max=0.5, start=0.05
    )
    reference = parameter("1", "Largest input", symbol="u_r", min=1e-12, start=1.0, tunable=False)
    given: ClassVar = ("reference",)
    relative_to_level: ClassVar = ("reference",)
    in_its_unit: ClassVar = ("reference",)

    @adds_to("force")
    def change(self, v, m):
        return v.quadratic_gain * (v.deflection / v.reference) * v.deflection


class InputLag(Effect):
    """The input acts with a lag of first order."""

    family, form, element = "input_lag", "first_order", "input"
    share = parameter("1", "Share of the input that lags", symbol="s", min=0, max=1, start=1.0)
    time_constant = parameter("s", "Time constant", symbol=r"\tau", min=1e-6, start=0.1)
    following = state("1", "Input, delayed by the time constant", symbol="z")
    starts: ClassVar = {"time_constant": (0.03, 0.1, 0.3, 1.0)}
    relative_to_period: ClassVar = ("time_constant",)
    in_its_unit: ClassVar = ("following",)

    @adds_to("der(following)")
    def follow(self, v, m):
        return (v.deflection - v.following) / v.time_constant

    @adds_to("force")
    def delay(self, v, m):
        return v.share * (v.following - v.deflection)


class InputDrift(Effect):
    """The gain of the input drifts steadily during the test."""

    family, form, element = "input_drift", "gain", "input"
    ratio = parameter("1", "Relative change of the gain over the duration", symbol="r", min=-1, max=1, start=0.05)
    duration = parameter("s", "Duration of the test", symbol="T", min=1e-3, start=200.0, tunable=False)
    given: ClassVar = ("duration",)

    @adds_to("force")
    def change(self, v, m):
        return v.ratio * (v.time / v.duration - 0.5) * v.deflection
