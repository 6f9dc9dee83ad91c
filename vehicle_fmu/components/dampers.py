"""Steering dampers: devices with the port of a rider and opposite torques at their two ends.

    linear        T_h = -c s                    = -T_f
    progressive   T_h = -(c_1 + c_2 |s|) s      = -T_f
    inerter       b z' = c (s - z),  T_h = -c (s - z) = -T_f     (inerter b in series with a damper c)

s is the steer rate. An inerter alone has no proper transfer function at this port; it is therefore in series with a
damper. Source: Cossalter et al., Meccanica 46 (2011), eq. 14 (which prints the opposite sign for T_h).
"""

from fmus import local, parameter, state
from fmus.interfaces.handlebar import HandlebarDevice


class LinearDamper(HandlebarDevice):
    """Linear steering damper."""

    family, form = "steer_damping", "linear"
    damping = parameter("N.m.s/rad", "Damping coefficient", symbol="c_d", min=0, max=1e4, start=7.5)
    damper_torque = local("N.m", "Torque of the damper on the front assembly", symbol="T_d")

    def equations(self, v, m):
        v.damper_torque = -v.damping * v.steer_rate
        return {"handlebar_torque": v.damper_torque, "frame_torque": -v.damper_torque}


class ProgressiveDamper(HandlebarDevice):
    """Steering damper whose coefficient grows with the steer rate."""

    family, form = "steer_damping", "progressive"
    damping = parameter("N.m.s/rad", "Damping coefficient at rest", symbol="c_1", min=0, max=1e4, start=4)
    progression = parameter(
        "N.m.s2/rad2", "Growth of the coefficient with the rate", symbol="c_2", min=0, max=1e4, start=1
    )
    damper_torque = local("N.m", "Torque of the damper on the front assembly", symbol="T_d")

    def equations(self, v, m):
        v.damper_torque = -(v.damping + v.progression * m.absolute(v.steer_rate)) * v.steer_rate
        return {"handlebar_torque": v.damper_torque, "frame_torque": -v.damper_torque}


class InerterCompensator(HandlebarDevice):
    """Inerter in series with a damper."""

    family, form = "steer_damping", "inerter"
    inertance = parameter("kg.m2", "Inertance", symbol="b", min=1e-6, max=100, start=0.1)
    damping = parameter("N.m.s/rad", "Damping in series with the inerter", symbol="c", min=0, max=1e4, start=5)
    inerter_rate = state("rad/s", "Rate across the inerter", symbol="z")
    damper_torque = local("N.m", "Torque of the damper on the front assembly", symbol="T_d")

    def equations(self, v, m):
        v.damper_torque = -v.damping * (v.steer_rate - v.inerter_rate)
        return {
            "der(inerter_rate)": -v.damper_torque / v.inertance,
            "handlebar_torque": v.damper_torque,
            "frame_torque": -v.damper_torque,
        }
