"""The passive rider: torso, arms and waist as springs and dampers between handlebar and frame.

    arm torque    T_a = k_a (theta - delta) + c_a (theta' - s)
    waist torque  T_w = k_t theta + c_t theta'
    torso         P' = -T_a - T_w,      P = I_t Omega + I_cc (s + w),      theta' = Omega - w
    port          T_h = T_a + (I_cc / I_t) (T_a + T_w) - T_s,      T_f = T_w + T_s

theta is the angle of the torso relative to the rear frame, Omega its ABSOLUTE rate, w the rate of the frame. If the
kinetic energy of the torso were written with theta' instead of Omega, the weave instability of the 2011 paper would
not appear. With the momentum P as state no acceleration is needed at the port, also for a cross inertia I_cc that is
not zero; the part of the steer inertia that I_cc replaces is in `port_inertia`. T_s is a torque between handlebar and
frame that is zero unless an effect adds to it.

Source: Cossalter, Doria, Lot, Massaro, Meccanica 46 (2011) 279-292, eqs 1, 2, 10 to 13; the cross inertia:
Cossalter, Doria, Fabris, Maso (2008), eqs 3, 4.
"""

from math import pi, sqrt
from typing import ClassVar

from fmus import Component, calculated, local, output, parameter, state
from fmus.declaration.elements import Element
from fmus.interfaces.handlebar import HandlebarDevice


class PassiveRider(HandlebarDevice):
    """Passive rider whose torso rotates about an axis parallel to the steer axis."""

    family, form = "passive_rider", "torso"
    torso_inertia = parameter(
        "kg.m2",
        "Inertia of the torso with a share of the arms about the waist axis",
        symbol="I_t",
        min=1e-3,
        max=20,
        start=0.6441,
    )
    arm_stiffness = parameter(
        "N.m/rad", "Stiffness of the arms between torso and handlebar", symbol="k_a", min=0, max=1e6, start=1053.4
    )
    waist_stiffness = parameter(
        "N.m/rad", "Stiffness of waist and saddle between torso and frame", symbol="k_t", min=0, max=1e6, start=75.8
    )
    arm_damping = parameter("N.m.s/rad", "Damping of the arms", symbol="c_a", min=0, max=1e5, start=19.28)
    waist_damping = parameter("N.m.s/rad", "Damping of waist and saddle", symbol="c_t", min=0, max=1e5, start=4.79)
    cross_inertia = parameter("kg.m2", "Cross-coupling inertia of steer and torso", symbol="I_{cc}", min=-5, max=5)
    added_steer_inertia = parameter(
        "kg.m2",
        "Share of the rider's inertia that moves with the handlebar",
        symbol="I_a",
        min=-5,
        max=5,
        tunable=False,
    )
    port_inertia = calculated(
        "kg.m2", "Inertia that the vehicle has to include as its added_steer_inertia", symbol="I_p"
    )

    torso_angle = state("rad", "Torso angle relative to the rear frame", symbol=r"\theta", exposed=True)
    torso_momentum = state("N.m.s", "Angular momentum of the torso", symbol="P")
    torso_rate = output("rad/s", "Absolute rate of the torso", symbol=r"\Omega")

    arm_deflection = local("rad", "Deflection of the arm spring", symbol="d")
    arm_rate = local("rad/s", "Rate of the arm deflection", symbol=r"\dot d")
    arm_torque = local("N.m", "Torque of the arms on the handlebar", symbol="T_a")
    waist_rate = local("rad/s", "Rate of the torso relative to the frame", symbol=r"\dot\theta")
    waist_torque = local("N.m", "Torque of the waist on the frame", symbol="T_w")
    head_torque = local("N.m", "Torque between handlebar and frame besides the rider", symbol="T_s")

    elements: ClassVar = {
        "arms": Element("arm_torque", "arm_deflection", "arm_rate", "arm_stiffness", "arm_damping"),
        "waist": Element("waist_torque", "torso_angle", "waist_rate", "waist_stiffness", "waist_damping"),
        "steering_head": Element("head_torque", "steer_angle", "steer_rate"),
    }

    def equations(self, v, m):
        ratio = v.cross_inertia / v.torso_inertia
        torso_rate = v.torso_momentum / v.torso_inertia - ratio * (v.steer_rate + v.frame_rate)
        v.waist_rate = torso_rate - v.frame_rate
        v.arm_deflection = v.torso_angle - v.steer_angle
        v.arm_rate = v.waist_rate - v.steer_rate
        v.arm_torque = v.arm_stiffness * v.arm_deflection + v.arm_damping * v.arm_rate
        v.waist_torque = v.waist_stiffness * v.torso_angle + v.waist_damping * v.waist_rate
        v.head_torque = 0.0
        return {
            "der(torso_angle)": v.waist_rate,
            "der(torso_momentum)": -v.arm_torque - v.waist_torque,
            "handlebar_torque": v.arm_torque + ratio * (v.arm_torque + v.waist_torque) - v.head_torque,
            "frame_torque": v.waist_torque + v.head_torque,
            "torso_rate": torso_rate,
            "port_inertia": v.added_steer_inertia - ratio * v.cross_inertia,
        }


def locked_steer_mode(rider: Component) -> tuple[float, float]:
    """(nu_t [Hz], zeta_t [1]): undamped frequency and damping ratio of the torso with the steer locked (2011, eqs 8,
    9).
    """
    p = rider.values
    stiffness = p["arm_stiffness"] + p["waist_stiffness"]
    damping = p["arm_damping"] + p["waist_damping"]
    return sqrt(stiffness / p["torso_inertia"]) / (2 * pi), damping / (2 * sqrt(stiffness * p["torso_inertia"]))
