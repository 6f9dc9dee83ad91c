"""Nonlinear springs: a force F(d) in addition to the linear k d."""

from typing import ClassVar

from fmus.declaration.variables import parameter
from fmus.effects.effect import Effect, adds_to


def beyond(x, limit, m):
    """The part of x beyond a limit to either side; zero between (dead zone)."""
    return m.where(x > limit, x - limit, m.where(x < -limit, x + limit, 0.0 * x))


class AddedSpring(Effect):
    """A linear spring acts in parallel."""

    form = "linear"
    stiffness = parameter("N.m/rad", "Stiffness of the added spring", symbol="k_s", min=0, start=5.0)

    @adds_to("force")
    def spring(self, v, m):
        return v.stiffness * v.deflection


class CubicHardening(Effect):
    """The spring stiffens with the square of its deflection."""

    family, form, element = "hardening_stiffness", "cubic", "spring"
    cubic_stiffness = parameter(
        "N.m/rad3", "Stiffness that grows with the square of the deflection", symbol="k_3", min=0, start=1e4
    )

    @adds_to("force")
    def cubic(self, v, m):
        return v.cubic_stiffness * v.deflection**3


class QuinticHardening(Effect):
    """The spring stiffens with the fourth power of its deflection."""

    family, form, element = "hardening_stiffness", "quintic", "spring"
    quintic_stiffness = parameter(
        "N.m/rad5", "Stiffness that grows with the fourth power of the deflection", symbol="k_5", min=0, start=1e6
    )

    @adds_to("force")
    def quintic(self, v, m):
        return v.quintic_stiffness * v.deflection**5


class SquareHardening(Effect):
    """The spring stiffens in proportion to its deflection."""

    family, form, element = "hardening_stiffness", "square", "spring"
    square_stiffness = parameter("N.m/rad2", "Stiffness that grows with the deflection", symbol="k_2", min=0, start=1e3)

    @adds_to("force")
    def square(self, v, m):
        return v.square_stiffness * m.absolute(v.deflection) * v.deflection


class ExponentialHardening(Effect):
    """The spring stiffens exponentially with its deflection, as tendons and skin do."""

    # Source: Fung, Elasticity of soft tissues in simple elongation, Am. J. Physiol. 213 (1967); here odd, and without
    # its linear part.
    family, form, element = "hardening_stiffness", "exponential", "spring"
    cubic_stiffness = parameter(
        "N.m/rad3", "Stiffness that grows with the square of a small deflection", symbol="k_3", min=0, start=1e4
    )
    width = parameter(
        "rad", "Deflection over which the stiffness grows e-fold", symbol="w", min=1e-4, max=10.0, start=0.05
    )
    starts: ClassVar = {"width": (0.25, 0.6)}
    relative: ClassVar = ("width",)

    @adds_to("force")
    def exponential(self, v, m):
        return 6 * v.cubic_stiffness * v.width**2 * (v.width * m.sinh(v.deflection / v.width) - v.deflection)


class AnyHardening(Effect):
    """The spring's force is an odd polynomial of its deflection."""

    family, form, element, flexible = "hardening_stiffness", "polynomial", "spring", True
    square_stiffness = parameter("N.m/rad2", "Odd quadratic part", symbol="k_2", start=1e3)
    cubic_stiffness = parameter("N.m/rad3", "Cubic part", symbol="k_3", start=1e4)
    quintic_stiffness = parameter("N.m/rad5", "Quintic part", symbol="k_5", start=1e6)

    @adds_to("force")
    def curve(self, v, m):
        d = v.deflection
        return v.square_stiffness * m.absolute(d) * d + v.cubic_stiffness * d**3 + v.quintic_stiffness * d**5


class Backlash(Effect):
    """The spring has backlash: small deflections give no force."""

    family, form, element = "backlash", "gap", "spring"
    half_gap = parameter("rad", "Half of the backlash", symbol="g", min=0, start=2e-3)

    @adds_to("force")
    def backlash(self, v, m):
        return -v.stiffness * m.where(
            v.deflection > v.half_gap, v.half_gap, m.where(v.deflection < -v.half_gap, -v.half_gap, v.deflection)
        )


class SoftBacklash(Effect):
    """The spring has backlash with a smooth transition."""

    family, form, element = "backlash", "soft", "spring"
    half_gap = parameter("rad", "Half of the backlash", symbol="g", min=0, start=2e-3)
    softness = parameter(
        "rad", "Deflection over which the stiffness develops", symbol="w", min=1e-5, max=1.0, start=2e-3
    )
    starts: ClassVar = {"softness": (0.03, 0.1, 0.3)}
    relative: ClassVar = ("softness",)
    at_most: ClassVar = {"softness": 1 / 3}  # a wider transition is a hardening spring: tanh(d/w) = d/w - d^3/(3 w^3)

    @adds_to("force")
    def backlash(self, v, m):
        return -v.stiffness * v.half_gap * m.tanh(v.deflection / v.softness)


class Asymmetry(Effect):
    """The spring is stiffer to one side than to the other."""

    family, form, element = "asymmetry", "bilinear", "spring"
    ratio = parameter("1", "Difference of the two stiffnesses over their sum", symbol="r", min=-1, max=1, start=0.05)

    @adds_to("force")
    def difference(self, v, m):
        return v.ratio * v.stiffness * m.absolute(v.deflection)


class QuadraticAsymmetry(Effect):
    """The spring is stiffer to one side, with a difference in proportion to the deflection."""

    family, form, element = "asymmetry", "quadratic", "spring"
    even_stiffness = parameter("N.m/rad2", "Even quadratic part of the spring's force", symbol="k_e", start=1e3)

    @adds_to("force")
    def difference(self, v, m):
        return v.even_stiffness * v.deflection**2


class Saturation(Effect):
    """The spring's force saturates at a limit."""

    family, form, element = "saturation", "clip", "spring"
    share = parameter(
        "1", "Share of the stiffness that is lost beyond the limit", symbol="s_x", min=0, max=1, start=0.5
    )
    limit = parameter("rad", "Deflection at which the force saturates", symbol="d_x", min=1e-9, start=0.5)
    starts: ClassVar = {"limit": (0.3, 0.5, 0.7, 0.85)}
    relative: ClassVar = ("limit",)

    @adds_to("force")
    def clipped(self, v, m):
        return -v.share * v.stiffness * beyond(v.deflection, v.limit, m)


class GeometricNonlinearity(Effect):
    """Large rotation: the restoring torque follows the sine of the angle, where the base is linear."""

    family, form, element, of_stiffness = "geometric_nonlinearity", "sine", "rotation", True
    share = parameter(
        "1", "Share of the stiffness that follows the sine of the deflection", symbol="s", min=0, max=1.5, start=0.5
    )

    @adds_to("force")
    def sine(self, v, m):
        return v.share * v.stiffness * (m.sin(v.deflection) - v.deflection)


class GravityTorque(Effect):
    """Large rotation: the torque of gravity follows the sine of the angle, where the base is linear."""

    family, form, element, of_stiffness = "geometric_nonlinearity", "gravity", "rotation", False
    gravity_torque = parameter(
        "N.m", "Torque of gravity at a right angle: mass, gravity and distance", symbol="m g l", min=0, start=1.0
    )

    @adds_to("force")
    def sine(self, v, m):
        return v.gravity_torque * (m.sin(v.deflection) - v.deflection)


class TurnedGravityTorque(Effect):
    """Large rotation: the torque of gravity follows the sine of the angle from a vertical that is not known."""

    family, form, element = "geometric_nonlinearity", "turned", "rotation"
    sine_torque = parameter("N.m", "Torque of gravity, its part with the sine of the angle", symbol="m g l_s", start=1.0)
    cosine_torque = parameter(
        "N.m", "Torque of gravity, its part with the cosine of the angle", symbol="m g l_c", start=1.0
    )

    @adds_to("force")
    def turned(self, v, m):
        return v.sine_torque * m.sin(v.deflection) + v.cosine_torque * m.cos(v.deflection)
