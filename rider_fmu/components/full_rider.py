"""The full rider of the 2008 paper: torso, two upper arms, two forearms and hands on the handlebar, large motion.

The closed arm loops (see `rider_fmu.full_rider.arm_loop`) leave two degrees of freedom, steer angle delta and torso
angle theta, with

    M(q) u' + b(q, q', u) = Q(q, q') + (M_s, 0)             (see `rider_fmu.full_rider.limbs`)

On the rig M_s is the torque of the servo. At the port of a vehicle delta is an input and the rates are absolute, as in
the linear rider: u = (s + w, Omega), theta' = Omega - w. With the momentum P of the torso as state and
kappa = M12 / M22 the torques depend on acceleration only through the inertia reflected to the steer axis:

    P' = T_2 + Q_2,    Omega = (P - M12 (s + w)) / M22
    T_h = Q_1 - b_1 - kappa (Q_2 - b_2) + (R'/2) (s + w)  - [R (s + w)' + (R'/2) (s + w)]
    T_f = -(T_1 + Q_1) - (T_2 + Q_2)

The energy is P^2 / (2 M22) + R (s + w)^2 / 2 + U(q). The bracket is the rate of its middle term, which belongs to the
reflected inertia R. The vehicle includes R of the rest posture, the output `port_inertia`, as its
`added_steer_inertia`. A vehicle with the effect `PostureInertia` (see `fmus.interfaces.posture_inertia`) also includes
the rest of the bracket, from the outputs `inertia_change`, R minus its value at rest, and `inertia_torque`, (R'/2) (s
+ w); this is exact. Any other vehicle neglects that rest. The energy of rider and vehicle is still balanced to
rounding; the neglected change of R with posture is an error of third order in the angles.

Source: Cossalter, Doria, Fabris, Maso, Measurement and identification of the vibration characteristics of
motorcycle riders (2008), Fig. 8, eqs 1, 2.
"""

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from fmus import Component, InputError, calculated, input, output, parameter, state
from fmus.expressions.functions import NUMERIC
from fmus.interfaces.handlebar import HandlebarDevice, port_input, port_output, port_state
from fmus.interfaces.posture_inertia import posture_output
from rider_fmu.full_rider.limbs import motion, reach
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA

STOPS, TWIST = 0.6, 0.35  # rad: bounds of steer and torso angle; the reach of the arms is checked separately
NEARLY_STRAIGHT = np.radians(5.0)  # elbow angle at which the closed form loses half of its digits


class Limbs(Component):
    """Lengths, masses and joints of the full rider, the base of its two forms."""

    steer_tilt = parameter(
        "rad", "Angle of the steer axis to the vertical", symbol=r"\epsilon", min=-0.2, max=1.2, start=0.4715
    )
    torso_inclination = parameter(
        "rad", "Forward lean of the waist axis from the vertical", symbol=r"\beta", min=-0.5, max=1.2, start=0.16
    )
    saddle_distance = parameter(
        "m", "Saddle centre to steering head, forward", symbol="l_{ss}", min=0, max=2, start=0.6
    )
    saddle_drop = parameter(
        "m", "Steering head above the saddle centre", symbol="h_{ss}", min=-0.5, max=1.5, start=0.35
    )
    hip_rise = parameter("m", "Hip joints above the saddle centre", symbol="h_h", min=0, max=0.5, start=0.08)
    torso_length = parameter(
        "m", "Hips to the line of the shoulders, along the waist axis", symbol="L_t", min=0.05, max=1.5, start=0.53
    )
    shoulder_half_width = parameter(
        "m", "Shoulder joint to the plane of symmetry", symbol="y_s", min=0.02, max=0.6, start=0.2
    )
    grip_setback = parameter(
        "m",
        "Wrists behind the steering head, perpendicular to the steer axis",
        symbol="x_g",
        min=-0.5,
        max=1,
        start=0.2,
    )
    grip_half_width = parameter("m", "Wrist to the plane of symmetry", symbol="y_g", min=0.02, max=1, start=0.34)
    grip_rise = parameter("m", "Wrists above the steering head, along the steer axis", symbol="z_g", min=-0.5, max=1)
    elbow_spread = parameter(
        "rad",
        "Direction of the elbow, set by the hand: 0 down the steer axis, pi/2 outward",
        symbol=r"\chi",
        min=-0.5,
        max=3,
        start=0.6,
    )
    upper_arm_length = parameter("m", "Shoulder to elbow", symbol="a", min=0.05, max=1, start=0.29)
    upper_arm_mass = parameter("kg", "Mass of an upper arm", symbol="m_a", min=0, max=20)
    upper_arm_centre = parameter("m", "Shoulder to the mass centre of the upper arm", symbol="c_a", min=0, max=1)
    upper_arm_inertia = parameter(
        "kg.m2", "Transverse inertia of an upper arm about its mass centre", symbol="J_a", min=0, max=1
    )
    forearm_length = parameter("m", "Elbow to wrist", symbol="b", min=0.05, max=1, start=0.275)
    forearm_mass = parameter("kg", "Mass of a forearm", symbol="m_b", min=0, max=20)
    forearm_centre = parameter("m", "Elbow to the mass centre of the forearm", symbol="c_b", min=0, max=1)
    forearm_inertia = parameter(
        "kg.m2", "Transverse inertia of a forearm about its mass centre", symbol="J_b", min=0, max=1
    )
    hand_mass = parameter("kg", "Mass of a hand", symbol="m_h", min=0, max=10)
    hands_inertia = parameter("kg.m2", "Inertia of both hands about the steer axis", symbol="I_h", min=0, max=2)
    trunk_inertia = parameter(
        "kg.m2", "Inertia of trunk and head about the waist axis", symbol="I_b", min=1e-3, max=20, start=0.4
    )
    waist_stiffness = parameter("N.m/rad", "Stiffness of the waist", symbol="k_t", min=0, max=1e6)
    waist_damping = parameter("N.m.s/rad", "Damping of the waist", symbol="c_t", min=0, max=1e5)
    shoulder_stiffness = parameter(
        "N.m/rad", "Stiffness of a shoulder, upper arm against torso", symbol="k_s", min=0, max=1e6
    )
    shoulder_damping = parameter("N.m.s/rad", "Damping of a shoulder", symbol="c_s", min=0, max=1e5)
    elbow_stiffness = parameter("N.m/rad", "Stiffness of an elbow", symbol="k_e", min=0, max=1e6)
    elbow_damping = parameter("N.m.s/rad", "Damping of an elbow", symbol="c_e", min=0, max=1e5)
    wrist_stiffness = parameter("N.m/rad", "Stiffness of a wrist, forearm against hand", symbol="k_w", min=0, max=1e6)
    wrist_damping = parameter("N.m.s/rad", "Damping of a wrist", symbol="c_w", min=0, max=1e5)
    gravity = parameter("m/s2", "Gravitational acceleration", symbol="g", min=0, max=100, start=9.80665)

    def _set_values(self, values: Mapping[str, float]) -> None:
        super()._set_values(values)
        check_posture(self, 0.0, 0.0)

    def derivatives(self, state: np.ndarray, inputs: np.ndarray, time: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """As `Component.derivatives`. Raises InputError for angles at which the arms cannot reach the grips."""
        at = dict(zip(self.states + self.inputs, (*state, *inputs), strict=True))
        check_posture(self, at["steer_angle"], at["torso_angle"])
        return super().derivatives(state, inputs, time)


class FullRider(Limbs, HandlebarDevice):
    """Full rider at the handlebar: six-body rider with closed arm loops."""

    port_inertia = calculated(
        "kg.m2", "Inertia that the vehicle has to include as its added_steer_inertia", symbol="I_p"
    )
    steer_angle = replace(port_input("steer_angle"), min=-STOPS, max=STOPS)
    torso_angle = state(
        "rad", "Torso angle relative to the rear frame", symbol=r"\theta", min=-TWIST, max=TWIST, exposed=True
    )
    torso_momentum = state("N.m.s", "Generalised momentum of the torso rotation", symbol="P")
    torso_rate = output("rad/s", "Absolute rate of the torso", symbol=r"\Omega")
    inertia_change = posture_output("inertia_change")
    inertia_torque = posture_output("inertia_torque")

    def equations(self, v, m):
        angles = (v.steer_angle, v.torso_angle)
        bar_rate = v.steer_rate + v.frame_rate
        still, at_rest = motion(v, m, angles), motion(v, m, (0.0, 0.0)).reflected_inertia
        torso_rate = m.term((v.torso_momentum - still.M12 * bar_rate) / still.M22)
        relative = (v.steer_rate, torso_rate - v.frame_rate)
        now = motion(v, m, angles, relative, (bar_rate, torso_rate))
        inertia_torque = now.reflected_slope / 2 * bar_rate
        steer_force, torso_force = (T + Q for T, Q in zip(now.kinetic_slope, now.Q, strict=True))
        return {
            "der(torso_angle)": relative[1],
            "der(torso_momentum)": torso_force,
            "handlebar_torque": now.Q[0] - now.b[0] - now.ratio * (now.Q[1] - now.b[1]) + inertia_torque,
            "frame_torque": -steer_force - torso_force,
            "torso_rate": torso_rate,
            "inertia_change": now.reflected_inertia - at_rest,
            "inertia_torque": inertia_torque,
            "port_inertia": at_rest,
        }


class FullRiderOnRig(Limbs):
    """Full rider on the steer test rig: handlebar and torso move, the servo's torque drives the bar."""

    bar_inertia = parameter(
        "kg.m2",
        "Inertia of the bare handlebar about the steer axis",
        symbol="I_0",
        min=0,
        max=20,
        start=HANDLEBAR_INERTIA,
    )
    servo_torque = input("N.m", "Torque of the servo, as the torsiometer measures it", symbol="M_s")
    handlebar_torque = port_input("handlebar_torque")
    frame_torque = port_input("frame_torque")
    frame_rate = port_output("frame_rate")
    steer_angle = replace(port_state("steer_angle"), min=-STOPS, max=STOPS)
    torso_angle = state(
        "rad", "Torso angle relative to the rear frame", symbol=r"\theta", min=-TWIST, max=TWIST, exposed=True
    )
    steer_rate = port_state("steer_rate")
    torso_rate = state("rad/s", "Absolute rate of the torso", symbol=r"\Omega", exposed=True)

    def mass(self, v, m):
        now = motion(v, m, (v.steer_angle, v.torso_angle))
        return {("steer_rate", "steer_rate"): v.bar_inertia + now.M11, ("steer_rate", "torso_rate"): now.M12,
                ("torso_rate", "steer_rate"): now.M12, ("torso_rate", "torso_rate"): now.M22}  # fmt: skip

    def equations(self, v, m):
        rates = (v.steer_rate, v.torso_rate)
        now = motion(v, m, (v.steer_angle, v.torso_angle), rates, rates)
        return {
            "der(steer_angle)": v.steer_rate,
            "der(torso_angle)": v.torso_rate,
            "der(steer_rate)": v.servo_torque + v.handlebar_torque + now.Q[0] - now.b[0],
            "der(torso_rate)": now.Q[1] - now.b[1],
            "frame_rate": 0.0,
        }


def on_rig(rider: Component, bar_inertia: float = HANDLEBAR_INERTIA) -> FullRiderOnRig:
    """The same rider on the steer test rig with a bar of inertia bar_inertia [kg.m2]."""
    return FullRiderOnRig(f"{rider.name}_on_rig", rider.source, (), bar_inertia=bar_inertia, **rider.values)


def check_posture(rider: Component, steer_angle: float, torso_angle: float) -> None:
    """Raise InputError where the arms cannot reach from the shoulders to the grips at these angles [rad]."""
    v = SimpleNamespace(**rider.values)
    for limb in ("upper_arm", "forearm"):
        if getattr(v, f"{limb}_centre") > getattr(v, f"{limb}_length"):
            raise InputError(
                f"{rider.name}: {limb}_centre = {getattr(v, f'{limb}_centre'):g} m lies beyond "
                f"{limb}_length = {getattr(v, f'{limb}_length'):g} m"
            )
    a, b = v.upper_arm_length, v.forearm_length
    straight, folded = (
        float(np.sqrt(a * a + b * b - 2 * a * b * np.cos(angle)))
        for angle in (np.pi - NEARLY_STRAIGHT, NEARLY_STRAIGHT)
    )
    for side, word in ((1, "right"), (-1, "left")):
        distance, clearance = reach(v, NUMERIC, side, steer_angle, torso_angle)
        angles = f"{np.degrees(steer_angle):.4g} deg of steer and {np.degrees(torso_angle):.4g} deg of torso"
        where = f"{rider.name}: at {angles} the {word} arm"
        if not folded <= distance <= straight:
            raise InputError(
                f"{where} must span {distance:.4g} m from shoulder to wrist; "
                f"upper_arm_length and forearm_length allow {folded:.4g} to {straight:.4g} m"
            )
        if clearance < np.sin(NEARLY_STRAIGHT):
            raise InputError(
                f"{where} points along the axis of the wrist that elbow_spread = {v.elbow_spread:.4g} rad sets; "
                "choose another elbow_spread"
            )
