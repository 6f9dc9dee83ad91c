"""A pendulum with the sine of its angle, as the base for swings whose large angles are known."""

from typing import ClassVar

from motofmi import Component, Element, input, local, parameter, state


class SinePendulum(Component):
    """Pendulum with the sine of its angle."""

    inertia = parameter("kg.m2", "Inertia", min=1e-9, max=1e6, start=0.1)
    damping = parameter("N.m.s/rad", "Damping", min=0, max=1e6, start=0.05)
    gravity_stiffness = parameter("N.m/rad", "Mass, gravity and distance", min=0, max=1e6, start=4.0)
    torque = input("N.m", "Torque")
    angle = state("rad", "Angle", exposed=True)
    rate = state("rad/s", "Rate", exposed=True)
    gravity_torque = local("N.m", "Torque of gravity and damping")

    elements: ClassVar = {"spring": Element("gravity_torque", "angle", "rate", "gravity_stiffness", "damping")}

    def equations(self, v, m):
        v.gravity_torque = v.gravity_stiffness * m.sin(v.angle) + v.damping * v.rate
        return {"der(angle)": v.rate, "der(rate)": (v.torque - v.gravity_torque) / v.inertia}
