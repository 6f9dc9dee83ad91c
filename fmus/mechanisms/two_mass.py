"""Two bodies on one axis, connected by a compliant shaft; a torque drives the first.

    J_1 s_1' = T - T_s - T_1,   q_1' = s_1,   T_1 = c_1 s_1
    J_2 s_2' = T_s - T_2,       q_2' = s_2,   T_2 = c_2 s_2
    T_s = k (q_1 - q_2) + c (s_1 - s_2)
"""

from typing import ClassVar

from fmus.declaration.component import Component
from fmus.declaration.elements import Element
from fmus.declaration.variables import input, local, parameter, state


class TwoMass(Component):
    """Drive and load connected by a compliant shaft: torque on the drive as input, angles as output."""

    drive_inertia = parameter("kg.m2", "Inertia of the drive", symbol="J_1", min=1e-9, max=1e6, start=0.02)
    load_inertia = parameter("kg.m2", "Inertia of the load", symbol="J_2", min=1e-9, max=1e6, start=0.05)
    stiffness = parameter("N.m/rad", "Stiffness of the shaft", symbol="k", min=0, max=1e9, start=40.0)
    damping = parameter("N.m.s/rad", "Damping of the shaft", symbol="c", min=0, max=1e6, start=0.05)
    drive_damping = parameter("N.m.s/rad", "Damping of the drive's bearing", symbol="c_1", min=0, max=1e6, start=0.1)
    load_damping = parameter("N.m.s/rad", "Damping of the load's bearing", symbol="c_2", min=0, max=1e6, start=0.05)
    torque = input("N.m", "Torque on the drive", symbol="T")
    angle = state("rad", "Angle of the drive", symbol="q_1", exposed=True)
    rate = state("rad/s", "Rate of the drive", symbol="s_1", exposed=True)
    load_angle = state("rad", "Angle of the load", symbol="q_2", exposed=True)
    load_rate = state("rad/s", "Rate of the load", symbol="s_2", exposed=True)
    twist = local("rad", "Twist of the shaft", symbol="d")
    twist_rate = local("rad/s", "Rate of the twist", symbol=r"\dot d")
    shaft_torque = local("N.m", "Torque of the shaft on the load", symbol="T_s")
    drive_torque = local("N.m", "Torque of the drive's bearing against its rate", symbol="T_1")
    load_torque = local("N.m", "Torque of the load's bearing against its rate", symbol="T_2")

    elements: ClassVar = {
        "spring": Element("shaft_torque", "twist", "twist_rate", "stiffness", "damping"),
        "drive": Element("drive_torque", "angle", "rate"),
        "load": Element("load_torque", "load_angle", "load_rate"),
    }

    def equations(self, v, m):
        v.twist = v.angle - v.load_angle
        v.twist_rate = v.rate - v.load_rate
        v.shaft_torque = v.stiffness * v.twist + v.damping * v.twist_rate
        v.drive_torque = v.drive_damping * v.rate
        v.load_torque = v.load_damping * v.load_rate
        return {
            "der(angle)": v.rate,
            "der(rate)": (v.torque - v.shaft_torque - v.drive_torque) / v.drive_inertia,
            "der(load_angle)": v.load_rate,
            "der(load_rate)": (v.shaft_torque - v.load_torque) / v.load_inertia,
        }
