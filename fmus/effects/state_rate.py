"""Laws of any state x, whatever it is: terms of its rate, in addition to those of the component.

    linear, square, cubic   x' += -k x,   -k |x| x,   -k x^3
    threshold               x' += -k max(x - x_0, 0)
    transfer                the same, of which the share s arrives at another state of the same unit

The linear term is a leakage to the reservoir at zero, the threshold an overflow. A transfer is that of one tank into
the next, or of one thermal mass to another.
"""

from typing import ClassVar

from fmus.declaration.variables import parameter
from fmus.effects.effect import Effect, adds_to


class Leakage(Effect):
    """The state falls in proportion to its value."""

    family, form, element = "leakage", "linear", "state"
    rate = parameter("1/s", "Relative rate of the loss", symbol="k_1", min=0, start=0.01)

    @adds_to("der(deflection)")
    def loss(self, v, m):
        return -v.rate * v.deflection


class SquareLeakage(Effect):
    """The state falls with the square of its value."""

    family, form, element = "leakage", "square", "state"
    square_rate = parameter("1/s", "Relative rate of the loss at the reference", symbol="k_2", min=0, start=0.01)
    reference = parameter("1", "Reference value of the state", symbol="x_r", min=1e-12, start=1.0, tunable=False)
    given: ClassVar = ("reference",)
    relative_to_level: ClassVar = ("reference",)
    in_its_unit: ClassVar = ("reference",)

    @adds_to("der(deflection)")
    def loss(self, v, m):
        return -v.square_rate * m.absolute(v.deflection) * v.deflection / v.reference


class CubicLeakage(Effect):
    """The state falls with the cube of its value."""

    family, form, element = "leakage", "cubic", "state"
    cubic_rate = parameter("1/s", "Relative rate of the loss at the reference", symbol="k_3", min=0, start=0.01)
    reference = parameter("1", "Reference value of the state", symbol="x_r", min=1e-12, start=1.0, tunable=False)
    given: ClassVar = ("reference",)
    relative_to_level: ClassVar = ("reference",)
    in_its_unit: ClassVar = ("reference",)

    @adds_to("der(deflection)")
    def loss(self, v, m):
        return -v.cubic_rate * v.deflection**3 / v.reference**2


class Overflow(Effect):
    """Above a threshold the state falls in proportion to the excess (overflow)."""

    family, form, element = "overflow", "lost", "state"
    rate = parameter("1/s", "Relative rate of the overflow", symbol="k_o", min=0, start=0.1)
    threshold = parameter("1", "Value above which the state overflows", symbol="x_0", start=1.0)
    starts: ClassVar = {"threshold": (0.5, 0.65, 0.8, 0.9)}
    within_range: ClassVar = ("threshold",)
    in_its_unit: ClassVar = ("threshold",)

    def excess(self, v, m):
        """The rate of the overflow."""
        return v.rate * m.where(v.deflection > v.threshold, v.deflection - v.threshold, 0.0 * v.deflection)

    @adds_to("der(deflection)")
    def loss(self, v, m):
        return -self.excess(v, m)


class Transfer(Overflow):
    """Above a threshold the state overflows, and a share of the excess arrives at another state."""

    form = "transfer"
    share = parameter("1", "Share of the overflow that arrives", symbol="s_o", min=0, max=1, start=0.5)
    starts: ClassVar = {"threshold": (0.5, 0.65, 0.8, 0.9), "share": (0.6,)}

    @adds_to("der(force)")
    def arrival(self, v, m):
        return v.share * self.excess(v, m)
