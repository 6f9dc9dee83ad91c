"""A body attached to a moving one by a spring and a damper: an additional mode.

    psi' = W - s,   W' = -(2 pi f)^2 psi - 4 pi zeta f (W - s),   F += I W'

psi is the deflection of the attached body, W its rate, s the rate of its base.
"""

from math import pi
from typing import ClassVar

from fmus.declaration.variables import parameter, state
from fmus.effects.effect import Effect, adds_to


class HungBody(Effect):
    """A further body is attached to the moving one by a spring and a damper."""

    family, form, element = "extra_mode", "hung_body", "spring"
    inertia = parameter("kg.m2", "Inertia of the body", symbol="I_h", min=0, start=0.01)
    frequency = parameter("Hz", "Undamped frequency with its base fixed", symbol="f_h", min=0.05, max=500, start=4.0)
    damping_ratio = parameter("1", "Damping ratio with its base fixed", symbol=r"\zeta_h", min=0.001, max=2, start=0.1)
    twist = state("rad", "Deflection of the body relative to its base", symbol=r"\psi")
    body_rate = state("rad/s", "Rate of the body", symbol="W")
    starts: ClassVar = {"frequency": (0.3, 0.5, 0.8, 1.25, 2.0, 3.25, 5.0, 8.0), "damping_ratio": (0.05, 0.3)}
    relative_to_frequency: ClassVar = ("frequency",)

    def acceleration(self, v):
        """The acceleration W' of the body [rad/s2]."""
        omega = 2 * pi * v.frequency
        return -(omega**2) * v.twist - 2 * v.damping_ratio * omega * (v.body_rate - v.rate)

    @adds_to("der(twist)")
    def turns(self, v, m):
        return v.body_rate - v.rate

    @adds_to("der(body_rate)")
    def swings(self, v, m):
        return self.acceleration(v)

    @adds_to("force")
    def reaction(self, v, m):
        return v.inertia * self.acceleration(v)
