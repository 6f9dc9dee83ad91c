"""Laws outside the library: parameter signs that its effects exclude, mixed laws F(d, d') of spring and damper, and a
sensor with memory.

They are compared with the effects of the library and are never named as an effect. Where one of them explains the data
better, the missing effect is outside the library, and a limitation states the law.
"""

from typing import ClassVar

from fmus.declaration.variables import parameter, state
from fmus.effects.effect import Effect, adds_to

FAMILY = "outside_library"
MEMORY = 0.01  # s, time constant of the sensor
SOFTENING = ("saturation", "geometric_nonlinearity")  # families that describe softening, where a library has them


class Softening(Effect):
    """The spring softens with the square of its deflection."""

    family, form, element, named_by = FAMILY, "softening", "spring", SOFTENING
    size = parameter("N.m/rad3", "Stiffness that is lost with the square of the deflection", min=0, start=1e4)

    @adds_to("force")
    def reduction(self, v, m):
        return -v.size * v.deflection**3


class SquareSoftening(Effect):
    """The spring softens in proportion to its deflection."""

    family, form, element, named_by = FAMILY, "square_softening", "spring", SOFTENING
    size = parameter("N.m/rad2", "Stiffness that is lost with the deflection", min=0, start=1e3)

    @adds_to("force")
    def reduction(self, v, m):
        return -v.size * m.absolute(v.deflection) * v.deflection


class Thinning(Effect):
    """The damping falls in proportion to the rate."""

    family, form, element = FAMILY, "thinning", "spring"
    size = parameter("N.m.s2/rad2", "Damping that is lost with the rate", min=0, start=1.0)

    @adds_to("force")
    def reduction(self, v, m):
        return -v.size * m.absolute(v.rate) * v.rate


class CubicThinning(Effect):
    """The damping falls with the square of the rate."""

    family, form, element = FAMILY, "cubic_thinning", "spring"
    size = parameter("N.m.s3/rad3", "Damping that is lost with the square of the rate", min=0, start=0.3)

    @adds_to("force")
    def reduction(self, v, m):
        return -v.size * v.rate**3


class EvenDamping(Effect):
    """A force grows with the square of the rate and has the same sign in both directions."""

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
    """A torque at the steering head grows with the angle and the square of its rate, as with a variable inertia."""

    form, element = "centrifugal", "steering_head"


class SensorMemory(Effect):
    """The force sensor has a memory: rising and falling loads have different readings."""

    family, form, element, part = FAMILY, "sensor_memory", "channel", "channel"
    size = parameter("N.m", "Excess of the reading for a rising load; negative for a lag", start=0.3)
    width = parameter(
        "N.m",
        "Change of the load within the memory at which the excess is nearly complete",
        min=1e-3,
        max=1e3,
        start=1.0,
    )
    before = state("N.m", "Load, delayed by the time constant of the sensor")
    starts: ClassVar = {"width": (0.3, 1.0, 3.0)}

    @adds_to("der(before)")
    def follow(self, v, m):
        return (v.force - v.before) / MEMORY

    @adds_to("force")
    def excess(self, v, m):
        return v.size * m.tanh((v.force - v.before) / v.width)
