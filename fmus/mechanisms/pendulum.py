"""A pendulum at small angles, driven by a torque. The sine of large angles is the effect `geometric_nonlinearity`.

    J s' = T - T_g,   q' = s,   T_g = k_g q + c s,   k_g = m g l

k_g is negative for an inverted pendulum.
"""

from typing import ClassVar

from fmus.declaration.component import Component
from fmus.declaration.elements import Element
from fmus.declaration.variables import input, local, parameter, state


class Pendulum(Component):
    """Pendulum, linear in its angle: torque as input, angle as output."""

    inertia = parameter("kg.m2", "Inertia about the joint", symbol="J", min=1e-9, max=1e6, start=0.1)
    damping = parameter("N.m.s/rad", "Damping of the joint", symbol="c", min=0, max=1e6, start=0.05)
    gravity_stiffness = parameter(
        "N.m/rad", "Mass times gravity times distance of the centre of mass", symbol="k_g", min=-1e6, max=1e6, start=4.0
    )
    torque = input("N.m", "Torque on the body", symbol="T")
    angle = state("rad", "Angle of the body", symbol="q", exposed=True)
    rate = state("rad/s", "Rate of the body", symbol="s", exposed=True)
    gravity_torque = local("N.m", "Torque of gravity and damping against the angle", symbol="T_g")

    elements: ClassVar = {
        "spring": Element("gravity_torque", "angle", "rate", "gravity_stiffness", "damping"),
        "rotation": Element("gravity_torque", "angle", "rate", "gravity_stiffness", "damping"),
    }

    def equations(self, v, m):
        v.gravity_torque = v.gravity_stiffness * v.angle + v.damping * v.rate
        return {"der(angle)": v.rate, "der(rate)": (v.torque - v.gravity_torque) / v.inertia}
