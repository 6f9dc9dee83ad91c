"""A body on a bearing, driven by a torque, with or without a spring.

    J s' = T - T_s,   q' = s,   T_s = k q + c s
"""

from typing import ClassVar

from fmus.declaration.component import Component
from fmus.declaration.elements import Element
from fmus.declaration.variables import input, local, parameter, state


class DrivenJoint(Component):
    """Joint with inertia, damping and an optional spring: torque as input, angle as output."""

    inertia = parameter("kg.m2", "Inertia about the joint", symbol="J", min=1e-9, max=1e6, start=0.1)
    damping = parameter("N.m.s/rad", "Damping of the joint", symbol="c", min=0, max=1e6, start=0.2)
    stiffness = parameter(
        "N.m/rad", "Stiffness of the joint; 0 is none, negative where it turns away from zero", symbol="k", min=-1e9,
        max=1e9, start=10.0,
    )
    torque = input("N.m", "Torque on the body", symbol="T")
    angle = state("rad", "Angle of the body", symbol="q", exposed=True)
    rate = state("rad/s", "Rate of the body", symbol="s", exposed=True)
    joint_torque = local("N.m", "Torque of spring and damper against the angle", symbol="T_s")

    elements: ClassVar = {
        "spring": Element("joint_torque", "angle", "rate", "stiffness", "damping"),
        "rotation": Element("joint_torque", "angle", "rate", "stiffness", "damping"),
    }

    def equations(self, v, m):
        v.joint_torque = v.stiffness * v.angle + v.damping * v.rate
        return {"der(angle)": v.rate, "der(rate)": (v.torque - v.joint_torque) / v.inertia}
