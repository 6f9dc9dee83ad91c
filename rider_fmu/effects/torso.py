"""Effects of the torso beyond one body on a linear waist: a further body, friction, coupled inertia."""

from math import pi
from typing import ClassVar

from fmus import Effect, adds_to, parameter, state
from fmus.effects import damping


class ExtraMode(Effect):
    """A body on the torso, such as the head, is attached by a spring and a damper.

    I W' = -k psi - c (W - Omega),   psi' = W - Omega,   k = I (2 pi f)^2,   c = 4 pi zeta f I
    """

    family, form = "extra_mode", "head"
    inertia = parameter("kg.m2", "Inertia of the body", symbol="I_h", min=0, max=5, start=0.05)
    frequency = parameter("Hz", "Undamped frequency with its base fixed", symbol="f_h", min=0.3, max=40, start=4.0)
    damping_ratio = parameter("1", "Damping ratio with its base fixed", symbol=r"\zeta_h", min=0.01, max=2, start=0.3)
    twist = state("rad", "Angle of the body relative to the torso", symbol=r"\psi")
    body_rate = state("rad/s", "Rate of the body, absolute", symbol="W")
    starts: ClassVar = {"frequency": (1.5, 3.0, 5.0, 8.0, 12.0), "damping_ratio": (0.15, 0.5)}

    def acceleration(self, v):
        """The acceleration W' of the body [rad/s2]."""
        omega = 2 * pi * v.frequency
        return -(omega**2) * self.pull(v) - 2 * v.damping_ratio * omega * self.difference(v)

    def pull(self, v):
        """The torque of the spring relative to its stiffness at rest."""
        return v.twist

    @staticmethod
    def difference(v):
        """W - Omega: the rate of the body relative to the torso [rad/s]."""
        return v.body_rate - (v.arm_rate + v.steer_rate + v.frame_rate)

    @adds_to("der(twist)")
    def turns(self, v, m):
        return self.difference(v)

    @adds_to("der(body_rate)")
    def swings(self, v, m):
        return self.acceleration(v)

    @adds_to("der(torso_momentum)")
    def reaction(self, v, m):
        return -v.inertia * self.acceleration(v)


class NeckMode(ExtraMode):
    """A body on the torso, such as the head, is attached by a nonlinear spring and a damper.

    I W' = -k psi (1 + b psi^2) - c (W - Omega)
    """

    form = "neck"
    bend = parameter(
        "1/rad2", "Relative change of the stiffness per square of the twist", symbol="b", min=-30, max=300, start=-0.5
    )
    starts: ClassVar = {**ExtraMode.starts, "bend": (-0.5,)}

    def pull(self, v):
        """The torque of the spring relative to its stiffness at rest."""
        return v.twist * (1 + v.bend * v.twist**2)


class WaistFriction(damping.CoulombFriction):
    """Dry friction between rider and saddle."""

    family, element = "waist_friction", "waist"


class AddedInertia(Effect):
    """More of the rider's inertia moves with the handlebar."""

    family, form = "added_inertia", "inertia"
    inertia = parameter("kg.m2", "Inertia that moves with the handlebar", symbol="I_a", min=0, max=5, start=0.01)

    @adds_to("added_steer_inertia")
    def hands(self, v, m):
        return v.inertia


class CrossInertia(Effect):
    """Steer and torso are coupled by an inertia."""

    family, form = "cross_inertia", "inertia"
    inertia = parameter(
        "kg.m2", "Cross-coupling inertia of steer and torso", symbol="I_{cc}", min=-1, max=1, start=0.01
    )

    @adds_to("cross_inertia")
    def coupling(self, v, m):
        return v.inertia
