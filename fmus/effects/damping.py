"""Nonlinear dampers and dry friction: a force F(d') in addition to the linear c d'.

    bilinear        F = r_c c |d'|,   c d' (1 + r_c) in one direction and c d' (1 - r_c) in the other
    coulomb, soft   F = T_c tanh(d' / s_0)
    stribeck        F = (T_c + T_s exp(-(d' / s_s)^2)) tanh(d' / s_0)
    lagging         F = T_c z,   t_f z' = tanh(d' / s_0) - z

Source: Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30 (1994) 1083-1138, on Stribeck's curve and frictional
memory.
"""

from typing import ClassVar

from fmus.declaration.variables import parameter, state
from fmus.effects.effect import Effect, adds_to


class AddedDamper(Effect):
    """A viscous damper acts in parallel."""

    form = "linear"
    damping = parameter("N.m.s/rad", "Damping of the added damper", symbol="c_s", min=0, start=0.5)

    @adds_to("force")
    def damper(self, v, m):
        return v.damping * v.rate


class ProgressiveDamping(Effect):
    """The damper's force grows with the square of its rate (drag)."""

    family, form, element = "progressive_damping", "quadratic", "spring"
    coefficient = parameter("N.m.s2/rad2", "Force per rate times absolute rate", symbol="c_2", min=0, start=1.0)

    @adds_to("force")
    def drag(self, v, m):
        return v.coefficient * m.absolute(v.rate) * v.rate


class CubicDamping(Effect):
    """The damper's force grows with the third power of its rate."""

    family, form, element = "progressive_damping", "cubic", "spring"
    cubic_coefficient = parameter("N.m.s3/rad3", "Force per cubed rate", symbol="c_3", min=0, start=0.3)

    @adds_to("force")
    def drag(self, v, m):
        return v.cubic_coefficient * v.rate**3


class AnyDamping(Effect):
    """The damper's force is an odd polynomial of its rate."""

    family, form, element, flexible = "progressive_damping", "polynomial", "spring", True
    coefficient = parameter("N.m.s2/rad2", "Odd quadratic part", symbol="c_2", start=1.0)
    cubic_coefficient = parameter("N.m.s3/rad3", "Cubic part", symbol="c_3", start=0.3)

    @adds_to("force")
    def drag(self, v, m):
        return v.coefficient * m.absolute(v.rate) * v.rate + v.cubic_coefficient * v.rate**3


class DampingAsymmetry(Effect):
    """The damper is stiffer in one direction than in the other."""

    family, form, element = "damping_asymmetry", "bilinear", "spring"
    both_ways: ClassVar = True
    ratio = parameter(
        "1", "Difference of the two damping coefficients over their sum", symbol="r_c", min=-1, max=1, start=0.05
    )

    @adds_to("force")
    def difference(self, v, m):
        return v.ratio * v.damping * m.absolute(v.rate)


class QuadraticDampingAsymmetry(Effect):
    """The damper is stiffer in one direction, with a difference in proportion to the rate."""

    family, form, element = "damping_asymmetry", "quadratic", "spring"
    both_ways: ClassVar = True
    even_coefficient = parameter("N.m.s2/rad2", "Even quadratic part of the damper's force", symbol="c_e", start=1.0)

    @adds_to("force")
    def difference(self, v, m):
        return v.even_coefficient * v.rate**2


class CoulombFriction(Effect):
    """Dry friction opposes the rate with a constant force."""

    family, form, element = "coulomb_friction", "coulomb", "spring"
    friction_torque = parameter("N.m", "Force of dry friction", symbol="T_c", min=0, start=0.5)
    sliding_rate = parameter(
        "rad/s", "Rate at which friction is nearly fully developed", symbol="s_0", min=1e-12, start=0.02
    )
    given: ClassVar[tuple[str, ...]] = ("sliding_rate",)

    @adds_to("force")
    def friction(self, v, m):
        return v.friction_torque * m.tanh(v.rate / v.sliding_rate)


class SoftFriction(CoulombFriction):
    """Dry friction whose transition through zero rate is wide."""

    form = "soft"
    given = ()
    starts: ClassVar = {"sliding_rate": (0.02, 0.1, 0.4)}
    relative_to_rate: ClassVar = ("sliding_rate",)
    # The transition of the Coulomb form is the narrowest one, so that a form with a width of its own contains it.
    at_least_sliding: ClassVar = {"sliding_rate": 1.0}
    # tanh(2) = 0.96: a force that is not developed at the largest rate is a damper, tanh(r/s) = r/s - r^3/(3 s^3)
    at_most_of_rate: ClassVar = {"sliding_rate": 0.5}


class LaggingFriction(SoftFriction):
    """Dry friction that follows the rate with a lag (frictional memory), as with a fluid or a lubricant film."""

    form = "lagging"
    lag = parameter(
        "s", "Time constant with which friction follows the rate", symbol="t_f", min=1e-4, max=1, start=0.01
    )
    following = state("1", "Friction relative to its maximum", symbol="z")
    starts: ClassVar = {"sliding_rate": (0.1, 0.4), "lag": (0.003, 0.03)}
    times: ClassVar = ("lag",)
    initial_deviations: ClassVar = {"following": 1.0}

    @adds_to("der(following)")
    def follow(self, v, m):
        return (m.tanh(v.rate / v.sliding_rate) - v.following) / v.lag

    @adds_to("force")
    def friction(self, v, m):
        return v.friction_torque * v.following


class StribeckFriction(CoulombFriction):
    """Dry friction that is larger near standstill than during sliding (Stribeck curve)."""

    form = "stribeck"
    breakaway = parameter(
        "N.m", "Friction near standstill in excess of sliding friction", symbol="T_s", min=0, start=0.3
    )
    stribeck_rate = parameter(
        "rad/s", "Rate at which the excess has decayed", symbol="s_s", min=1e-3, max=10, start=0.1
    )
    given = ("sliding_rate",)
    starts: ClassVar = {"stribeck_rate": (0.1, 0.4)}
    relative_to_rate: ClassVar = ("stribeck_rate",)
    # At twice the sliding rate friction is developed to 96 %; an excess at lower rates is not visible.
    at_least_sliding: ClassVar = {"stribeck_rate": 2.0}

    @adds_to("force")
    def friction(self, v, m):
        return (v.friction_torque + v.breakaway * m.exp(-((v.rate / v.stribeck_rate) ** 2))) * m.tanh(
            v.rate / v.sliding_rate
        )
