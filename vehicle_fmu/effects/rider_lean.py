r"""The rider's upper body leans on the rear frame: an inverted pendulum, sprung and damped, about an axis along x.

Its hinge is at the height h_s above the ground, its mass centre c_r above the hinge (and x_r ahead of the origin), its
radius of gyration rho. The body is already a part of the rigid rear frame; only its lean theta relative to the frame is
added. With m the leaning mass:

    lateral  ... + m c_r theta''
    yaw      ... + m c_r x_r theta''
    roll     ... + m (rho^2 + c_r (h_s + c_r)) theta'' - m g c_r theta
    lean     the same column as row,
             + m (rho^2 + c_r^2) (theta'' + 2 zeta w theta' + w^2 theta) + m c_r V r - m g c_r phi = 0

w is the natural frequency with the frame held upright, the weight of the body included. The row is divided by m, so
that the effect vanishes for m = 0.

Source: the degree of freedom is that of Nishimi, Aoki, Katayama, SAE 850510 (1985), and of Cossalter et al. (2008),
Sect. 4; the equations are those of a rigid body in roll and are verified by a derivation with Kane's equations in the
tests.
"""

from math import pi
from typing import ClassVar

from fmus import Effect, adds_to, parameter, state


class RiderLean(Effect):
    """The rider's upper body leans on the frame."""

    family, form = "rider_lean", "pendulum"
    mass = parameter("kg", "Mass that leans", symbol="m_u", min=0, max=150, start=30.0)
    frequency = parameter(
        "Hz", "Undamped frequency with the frame held upright", symbol="f_l", min=0.2, max=20, start=1.5
    )
    damping_ratio = parameter(
        "1", "Damping ratio with the frame held upright", symbol=r"\zeta_l", min=0.01, max=2, start=0.3
    )
    hinge_height = parameter("m", "Hinge above the ground", symbol="h_s", min=0, max=2, start=0.8)
    centre = parameter("m", "Mass centre of the body above the hinge", symbol="c_r", min=0.05, max=1, start=0.35)
    gyration = parameter(
        "m", "Radius of gyration of the body about its mass centre", symbol=r"\rho", min=0, max=1, start=0.2
    )
    advance = parameter("m", "Mass centre of the body ahead of the origin", symbol="x_r", min=-2, max=2, start=0.0)
    lean = state("rad", "Lean of the body relative to the frame, to the right positive", symbol=r"\vartheta_u")
    lean_rate = state("rad/s", "Rate of the lean", symbol="q_u")
    given: ClassVar = ("hinge_height", "centre", "gyration", "advance")
    starts: ClassVar = {"frequency": (0.8, 1.6, 3.0, 6.0), "damping_ratio": (0.15, 0.5)}

    @staticmethod
    def own(v):
        """rho^2 + c_r^2: inertia about the hinge per mass [m2]."""
        return v.gyration**2 + v.centre**2

    @staticmethod
    def rolling(v):
        """rho^2 + c_r (h_s + c_r): product of inertia with the roll axis per mass [m2]."""
        return v.gyration**2 + v.centre * (v.hinge_height + v.centre)

    @adds_to("mass(lean_rate, lean_rate)")
    def with_itself(self, v, m):
        return self.own(v) - 1.0  # a state's entry is 1 before

    @adds_to("mass(lateral_velocity, lean_rate)")
    def on_lateral(self, v, m):
        return v.mass * v.centre

    @adds_to("mass(yaw_rate, lean_rate)")
    def on_yaw(self, v, m):
        return v.mass * v.centre * v.advance

    @adds_to("mass(roll_rate, lean_rate)")
    def on_roll(self, v, m):
        return v.mass * self.rolling(v)

    @adds_to("mass(lean_rate, lateral_velocity)")
    def from_lateral(self, v, m):
        return v.centre

    @adds_to("mass(lean_rate, yaw_rate)")
    def from_yaw(self, v, m):
        return v.centre * v.advance

    @adds_to("mass(lean_rate, roll_rate)")
    def from_roll(self, v, m):
        return self.rolling(v)

    @adds_to("der(lean)")
    def leans(self, v, m):
        return v.lean_rate

    @adds_to("der(lean_rate)")
    def swings(self, v, m):
        w = 2 * pi * v.frequency
        held = self.own(v) * (w**2 * v.lean + 2 * v.damping_ratio * w * v.lean_rate)
        return v.centre * (v.gravity * v.roll_angle - v.speed * v.yaw_rate) - held

    @adds_to("der(roll_rate)")
    def falls(self, v, m):
        return v.mass * v.gravity * v.centre * v.lean
