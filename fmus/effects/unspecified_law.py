"""Laws that have no name in the library: signs that its effects must not have, mixed laws F(d, d') of spring and damper, a sensor with a memory.

They are never named. Where one of them explains data better than any name does, what is missing is not in the library.
"""

from typing import ClassVar

from fmus.effects.effect import Effect, adds_to
from fmus.variables import parameter, state

FAMILY = "unlisted"
MOMENT = 0.01  # s
SOFTENING = ("saturation", "geometric_nonlinearity")  # families that name it, where a library has them


class Softening(Effect):
    """The spring softens with the square of its deflection."""

    family, form, element, named_by = FAMILY, "softening", "spring", SOFTENING
    size = parameter("N.m/rad3", "Stiffness that is lost with the square of the deflection", min=0, start=1e4)

    @adds_to("force")
    def lost(self, v, m):
        return -v.size * v.deflection**3


class SquareSoftening(Effect):
    """The spring softens in proportion to its deflection."""

    family, form, element, named_by = FAMILY, "square_softening", "spring", SOFTENING
    size = parameter("N.m/rad2", "Stiffness that is lost with the deflection", min=0, start=1e3)

    @adds_to("force")
    def lost(self, v, m):
        return -v.size * m.absolute(v.deflection) * v.deflection


class Thinning(Effect):
    """The damping falls in proportion to the rate."""

    family, form, element = FAMILY, "thinning", "spring"
    size = parameter("N.m.s2/rad2", "Damping that is lost with the rate", min=0, start=1.0)

    @adds_to("force")
    def lost(self, v, m):
        return -v.size * m.absolute(v.rate) * v.rate


class CubicThinning(Effect):
    """The damping falls with the square of the rate."""

    family, form, element = FAMILY, "cubic_thinning", "spring"
    size = parameter("N.m.s3/rad3", "Damping that is lost with the square of the rate", min=0, start=0.3)

    @adds_to("force")
    def lost(self, v, m):
        return -v.size * v.rate**3


class EvenDamping(Effect):
    """A force grows with the square of the rate and pushes to the same side both ways."""

    family, form, element = FAMILY, "even_damping", "spring"
    size = parameter("N.m.s2/rad2", "Force per squared rate", start=0.3)

    @adds_to("force")
    def push(self, v, m):
        return v.size * v.rate**2


class Product(Effect):
    """The damping is larger to one side than to the other: a force grows with deflection times rate."""

    family, form, element = FAMILY, "product", "spring"
    size = parameter("N.m.s/rad2", "Force per deflection and rate", start=10.0)

    @adds_to("force")
    def mixed(self, v, m):
        return v.size * v.deflection * v.rate


class DampingByDeflection(Effect):
    """The damping changes with the square of the deflection."""

    family, form, element = FAMILY, "damping_by_deflection", "spring"
    size = parameter("N.m.s/rad3", "Force per squared deflection and rate", start=100.0)

    @adds_to("force")
    def mixed(self, v, m):
        return v.size * v.deflection**2 * v.rate


class StiffnessByRate(Effect):
    """The stiffness changes with the square of the rate."""

    family, form, element = FAMILY, "stiffness_by_rate", "spring"
    size = parameter("N.m.s2/rad3", "Force per deflection and squared rate", start=10.0)

    @adds_to("force")
    def mixed(self, v, m):
        return v.size * v.deflection * v.rate**2


class Centrifugal(StiffnessByRate):
    """At the head a torque grows with the angle and the square of its rate, as of an inertia that changes with the angle."""

    form, element = "centrifugal", "head"


class SensorMemory(Effect):
    """The sensor of the force has a memory: it shows a load that grows unlike one that falls."""

    family, form, element, part = FAMILY, "sensor_memory", "channel", "channel"
    size = parameter("N.m", "What it shows more of a growing load; less than zero where it lags", start=0.3)
    width = parameter("N.m", "Change of the load within a moment at which that is nearly all there", min=1e-3, max=1e3, start=1.0)
    before = state("N.m", "The load a moment ago")
    starts: ClassVar = {"width": (0.3, 1.0, 3.0)}

    @adds_to("der(before)")
    def follow(self, v, m):
        return (v.force - v.before) / MOMENT

    @adds_to("force")
    def remember(self, v, m):
        return v.size * m.tanh((v.force - v.before) / v.width)
