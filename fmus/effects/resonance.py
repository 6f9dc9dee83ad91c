"""A body that hangs on another by a spring and a damper and swings on its own.

    psi' = W - s,   W' = -(2 pi f)^2 psi - 4 pi zeta f (W - s),   F += I W'

psi is its deflection against the body that it hangs on, W its own rate, s that body's.
"""

from math import pi
from typing import ClassVar

from fmus.effects.effect import Effect, adds_to
from fmus.variables import parameter, state


class HungBody(Effect):
    """A further body hangs on the moving one and swings on its own."""

    family, form, element = "extra_mode", "hung_body", "spring"
    inertia = parameter("kg.m2", "Inertia of the body", symbol="I_h", min=0, start=0.01)
    frequency = parameter("Hz", "Undamped frequency with its base fixed", symbol="f_h", min=0.05, max=500, start=4.0)
    damping_ratio = parameter("1", "Damping ratio with its base fixed", symbol=r"\zeta_h", min=0.001, max=2, start=0.1)
    twist = state("rad", "Deflection of the body against what it hangs on", symbol=r"\psi")
    body_rate = state("rad/s", "Rate of the body", symbol="W")
    starts: ClassVar = {"frequency": (0.6, 1.0, 1.6, 2.5, 4.0, 6.5, 10.0, 16.0), "damping_ratio": (0.05, 0.3)}

    def acceleration(self, v):
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
