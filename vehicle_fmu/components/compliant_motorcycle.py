r"""The motorcycle of Sharp (1994): compliant steering head and rear frame, a rider who rolls, load-dependent tyres.

Bodies: rear frame with the rider's lower body and the engine's flywheel; rear wheel assembly; rider's upper body; front
frame with the front wheel. Freedoms, in the order of `vehicle_fmu.out_of_plane`, whose equations apply:

    v, r, phi                   lateral velocity, yaw rate and roll of the rear frame about the line through the contacts
    d       (front frame)       slide of the front frame at the steering head                         k_d d + c_d d'
    beta    (front frame)       twist of the front frame about an axis through the head, at the inclination eta above
                                the horizontal; normal to the steer axis where eta = eps     k_beta beta + c_beta beta'
    delta   (front frame)       steer about the axis (sin eps, cos eps) through the head          T_s = K_s delta + K s
    lambda  (rear assembly)     twist about the axis (sin eps_t, cos eps_t) through the point of the rear frame at the
                                distance a_r from the rear contact, at the angle eps_1   k_lambda lambda + c_lambda lambda'
    zeta    (upper body)        roll about an axis along x at the height h_s                    k_zeta zeta + c_zeta zeta'

The tyres are those of `vehicle_fmu.load_dependent_tyres`. With the wheelbase w and the drag D V^2 at the height h_p the
loads are in equilibrium with weight, drag and lift L V^2 at half the wheelbase:

    w Z_f = g sum m_i (b + x_i) - V^2 (D h_p + L w / 2),       Z_r = g sum m_i - L V^2 - Z_f

Where the longitudinal forces act (chi = 1), the drag is on the rear frame, the front tyre has the rolling resistance
R_f = Z_f (C_0 + C_2 V^2) against its heading, and the rear tyre the drive D V^2 + R_f along its heading.

Hands on the bar add stiffness, damping and inertia of the steer (kappa = 1): K_s, K, I_fz change from their values with
the hands off to those with the hands on. A rider at the handlebar port replaces them, so that kappa = 0 with such a
rider. The torques of the port act as in Sharp's motorcycle of 1971: T_h on roll, yaw and steer, T_f on roll and yaw.

Source: Sharp, Vehicle System Dynamics 23 (1994) 425-443. The equations are derived here; the tests derive them a second
time with Kane's equations.
"""

from typing import Any, ClassVar

from fmus import local, parameter, state
from fmus.declaration.elements import Element
from vehicle_fmu.load_dependent_tyres import LoadDependentTyres, set_tyre
from vehicle_fmu.out_of_plane import (
    GROUND,
    Body,
    Freedom,
    forward_force,
    heading,
    inertia_force,
    lateral_velocity,
    mass_matrix,
    side_force,
    tilt,
    vertical_force,
)
from vehicle_fmu.steered_vehicle import SteeredOnTyres, port_motion, port_torques


class CompliantMotorcycle(SteeredOnTyres, LoadDependentTyres):
    """Motorcycle with compliant steering head and rear frame, a rider who rolls and load-dependent tyres."""

    front_mass = parameter("kg", "Mass of the front frame", symbol="M_f", min=1e-3, max=1e4, start=40.0)
    frame_mass = parameter("kg", "Mass of the rear frame with the rider's lower body", symbol="M_r", min=1e-3, max=1e5,
                           start=170.0)  # fmt: skip
    assembly_mass = parameter("kg", "Mass of the rear wheel assembly", symbol="M_b", min=1e-3, max=1e4, start=25.0)
    upper_body_mass = parameter("kg", "Mass of the rider's upper body", symbol="M_p", min=1e-3, max=1e3, start=50.0)
    front_cross_inertia = parameter("kg.m2", "Inertia of the front frame about the forward one of its axes",
                                    symbol="I_{fx}", min=0, max=1e4, start=4.0)  # fmt: skip
    front_steer_inertia = parameter("kg.m2", "Inertia of the front frame about the upright one of its axes, hands off",
                                    symbol="I_{fz}", min=1e-6, max=1e4, start=0.7)  # fmt: skip
    hands_steer_inertia = parameter("kg.m2", "Inertia of the front frame about the same axis, hands on",
                                    symbol="I_{fz1}", min=1e-6, max=1e4, start=0.9)  # fmt: skip
    front_product_of_inertia = parameter("kg.m2", "Product of inertia of the front frame in its own axes",
                                         symbol="I_{fxz}", min=-1e4, max=1e4)  # fmt: skip
    front_inertia_inclination = parameter("rad", "Rearward inclination of the front frame's own axes from the vertical",
                                          symbol=r"\epsilon_I", min=-1.5, max=1.5)  # fmt: skip
    frame_roll_inertia = parameter("kg.m2", "Roll inertia of the rear frame about its mass centre", symbol="I_{rx}",
                                   min=1e-6, max=1e5, start=7.0)  # fmt: skip
    frame_yaw_inertia = parameter("kg.m2", "Yaw inertia of the rear frame about its mass centre", symbol="I_{rz}",
                                  min=1e-6, max=1e5, start=11.0)  # fmt: skip
    frame_product_of_inertia = parameter("kg.m2", "Integral of x z dm of the rear frame, z down", symbol="C_{rxz}",
                                         min=-1e5, max=1e5)  # fmt: skip
    upper_body_roll_inertia = parameter("kg.m2", "Roll inertia of the rider's upper body about its mass centre",
                                        symbol="I_{px}", min=1e-6, max=1e3, start=2.0)  # fmt: skip
    upper_body_yaw_inertia = parameter("kg.m2", "Yaw inertia of the rider's upper body about its mass centre",
                                       symbol="I_{pz}", min=1e-6, max=1e3, start=0.5)  # fmt: skip
    upper_body_product_of_inertia = parameter("kg.m2", "Integral of x z dm of the rider's upper body, z down",
                                              symbol="C_{pxz}", min=-1e3, max=1e3)  # fmt: skip
    assembly_inertia = parameter("kg.m2", "Inertia of the rear wheel assembly about a diameter of the wheel",
                                 symbol="I_{bx}", min=1e-6, max=1e3, start=0.4)  # fmt: skip
    rear_spin_inertia = parameter("kg.m2", "Polar inertia of the rear wheel", symbol="i_{ry}", min=0, max=1e3)
    engine_spin_inertia = parameter("kg.m2", "Polar inertia of the engine as seen at the rear wheel", symbol="i_e",
                                    min=-1e3, max=1e3)  # fmt: skip
    trail = parameter("m", "Trail, perpendicular to the steer axis", symbol="t", min=-1, max=1)
    front_contact_distance = parameter("m", "Origin to the front contact, forwards", symbol="l", min=0, max=10, start=0.8)
    rear_contact_distance = parameter("m", "Origin to the rear contact, backwards", symbol="b", min=0, max=10, start=0.6)
    front_mass_offset = parameter("m", "Front mass centre ahead of the steer axis", symbol="e", min=-2, max=2)
    front_mass_height = parameter("m", "Height of the front mass centre", symbol="j", min=0, max=5, start=0.5)
    frame_mass_height = parameter("m", "Height of the rear frame's mass centre", symbol="h", min=0, max=10, start=0.4)
    assembly_mass_distance = parameter("m", "Origin to the mass centre of the rear wheel assembly, backwards",
                                       symbol="b_b", min=-5, max=10, start=0.6)  # fmt: skip
    assembly_mass_height = parameter("m", "Height of the mass centre of the rear wheel assembly", symbol="h_b", min=0,
                                     max=5, start=0.3)  # fmt: skip
    upper_body_distance = parameter("m", "Origin to the joint and the mass centre of the rider's upper body, backwards",
                                    symbol="b_p", min=-5, max=5, start=0.3)  # fmt: skip
    upper_body_rise = parameter("m", "Mass centre of the rider's upper body above its joint", symbol="h_p", min=-5,
                                max=5, start=0.4)  # fmt: skip
    upper_body_joint_height = parameter("m", "Height of the joint of the rider's upper body", symbol="h_s", min=0, max=5,
                                        start=0.8)  # fmt: skip
    head_height = parameter("m", "Height of the steering head, on the steer axis", symbol="s_h", min=-5, max=5,
                            start=0.8)  # fmt: skip
    head_twist_inclination = parameter("rad", "Inclination of the twist axis of the head above the horizontal",
                                       symbol=r"\eta", min=-1.5, max=1.5)  # fmt: skip
    rear_twist_distance = parameter("m", "Rear contact to the joint of the rear wheel assembly", symbol="a_r", min=-5,
                                    max=5, start=0.5)  # fmt: skip
    rear_twist_angle = parameter("rad", "Angle above the horizontal at which that joint is seen from the rear contact",
                                 symbol=r"\epsilon_1", min=-3.2, max=3.2, start=1.4)  # fmt: skip
    rear_twist_inclination = parameter("rad", "Rearward inclination of the twist axis at that joint from the vertical",
                                       symbol=r"\epsilon_t", min=-3.2, max=3.2, start=1.4)  # fmt: skip
    head_lateral_stiffness = parameter("N/m", "Lateral stiffness of the steering head", symbol="k_d", min=0, max=1e15,
                                       start=1e6)  # fmt: skip
    head_lateral_damping = parameter("N.s/m", "Lateral damping of the steering head", symbol="c_d", min=0, max=1e9)
    head_twist_stiffness = parameter("N.m/rad", "Torsional stiffness of the steering head", symbol=r"k_\beta", min=0,
                                     max=1e15, start=6e4)  # fmt: skip
    head_twist_damping = parameter("N.m.s/rad", "Torsional damping of the steering head", symbol=r"c_\beta", min=0, max=1e9)
    assembly_twist_stiffness = parameter("N.m/rad", "Torsional stiffness of the rear wheel assembly",
                                         symbol=r"k_\lambda", min=0, max=1e15, start=5e4)  # fmt: skip
    assembly_twist_damping = parameter("N.m.s/rad", "Torsional damping of the rear wheel assembly",
                                       symbol=r"c_\lambda", min=0, max=1e9)  # fmt: skip
    upper_body_stiffness = parameter("N.m/rad", "Roll stiffness of the rider's upper body against the frame",
                                     symbol=r"k_\zeta", min=0, max=1e15, start=1e4)  # fmt: skip
    upper_body_damping = parameter("N.m.s/rad", "Roll damping of the rider's upper body against the frame",
                                   symbol=r"c_\zeta", min=0, max=1e9)  # fmt: skip
    hands_on = parameter("1", "Hands on the bar (1) or off, or a rider at the handlebar port (0)",
                         symbol=r"\kappa", min=0, max=1)  # fmt: skip
    steering_stiffness = parameter("N.m/rad", "Stiffness of the steer, hands off", symbol="K_{s0}", min=0, max=1e6)
    steering_damping = parameter("N.m.s/rad", "Damping of the steer, hands off", symbol="K_0", min=0, max=1e4)
    hands_steering_stiffness = parameter("N.m/rad", "Stiffness of the steer, hands on", symbol="K_{s1}", min=0, max=1e6)
    hands_steering_damping = parameter("N.m.s/rad", "Damping of the steer, hands on", symbol="K_1", min=0, max=1e4)
    drag = parameter("N.s2/m2", "Drag per squared speed", symbol="D", min=0, max=10)
    lift = parameter("N.s2/m2", "Lift per squared speed", symbol="L", min=-10, max=10)
    pressure_height = parameter("m", "Height of the centre of pressure", symbol="h_c", min=0, max=5)
    rolling_resistance = parameter("1", "Rolling resistance per load", symbol="C_0", min=0, max=1)
    rolling_resistance_rise = parameter("s2/m2", "Rolling resistance per load and squared speed", symbol="C_2", min=0, max=1)
    longitudinal_forces = parameter("1", "Whether drag, rolling resistance and drive act (1) or change the loads only (0)",
                                    symbol=r"\chi", min=0, max=1, start=1)  # fmt: skip


    head_slide_rate = state("m/s", "Rate of the slide of the front frame at the head", symbol=r"\dot d")
    head_twist_rate = state("rad/s", "Rate of the twist of the front frame at the head", symbol=r"\dot\beta")
    assembly_twist_rate = state("rad/s", "Rate of the twist of the rear wheel assembly", symbol=r"\dot\lambda")
    upper_body_rate = state("rad/s", "Roll rate of the rider's upper body relative to the frame", symbol=r"\dot\zeta")
    head_slide = state("m", "Slide of the front frame at the head, to the right", symbol="d", nominal=1e-3)
    head_twist = state("rad", "Twist of the front frame at the head, to the right", symbol=r"\beta", nominal=1e-2)
    assembly_twist = state("rad", "Twist of the rear wheel assembly, to the right", symbol=r"\lambda_r", nominal=1e-2)
    upper_body_angle = state("rad", "Roll of the rider's upper body relative to the frame", symbol=r"\zeta", exposed=True)

    head_force = local("N", "Force of the steering head against its slide", symbol="F_d")
    head_twist_torque = local("N.m", "Torque of the steering head against its twist", symbol=r"T_\beta")
    assembly_torque = local("N.m", "Torque of the rear frame against the twist of the assembly", symbol=r"T_\lambda")
    upper_body_torque = local("N.m", "Torque of the saddle against the roll of the upper body", symbol=r"T_\zeta")

    elements: ClassVar = {
        **SteeredOnTyres.elements,
        "head_slide": Element("head_force", "head_slide", "head_slide_rate", "head_lateral_stiffness",
                              "head_lateral_damping"),
        "head_twist": Element("head_twist_torque", "head_twist", "head_twist_rate", "head_twist_stiffness",
                              "head_twist_damping"),
        "rear_frame": Element("assembly_torque", "assembly_twist", "assembly_twist_rate", "assembly_twist_stiffness",
                              "assembly_twist_damping"),
        "saddle": Element("upper_body_torque", "upper_body_angle", "upper_body_rate", "upper_body_stiffness",
                          "upper_body_damping"),
    }  # fmt: skip

    def mass(self, v, m):
        body = bodies(v, m)
        return mass_matrix(list(body.values()), freedoms(body))

    def equations(self, v, m):
        body = bodies(v, m)
        front, rear = body["front frame"].path, body["assembly"].path
        contacts = {"front": (front, (v.front_contact_distance, 0)), "rear": (rear, (-v.rear_contact_distance, 0))}
        loads = wheel_loads(v, body)
        derivatives: dict[str, Any] = {}
        for end, (path, contact) in contacts.items():
            slip = heading(path, v) - lateral_velocity(path, contact, v) / v.speed
            derivatives |= set_tyre(v, end, loads[end], slip, tilt(path, v))
        set_torques(v)
        own = {**port_torques(v, m), "head_slide_rate": -v.head_force, "head_twist_rate": -v.head_twist_torque,
               "assembly_twist_rate": -v.assembly_torque, "upper_body_rate": -v.upper_body_torque}  # fmt: skip
        for j in freedoms(body):
            derivatives[f"der({j.rate})"] = own[j.rate] + inertia_force(j, body.values(), v) + outer_force(
                j, body, contacts, v)  # fmt: skip
            if j.angle:
                derivatives[f"der({j.angle})"] = v[j.rate]
        return {**derivatives, **port_motion(v, m)}


def bodies(v: Any, m: Any) -> dict[str, Body]:
    """The bodies by name, with the freedoms of their paths."""
    c, S = m.cos(v.caster_angle), m.sin(v.caster_angle)
    head = (v.front_contact_distance + v.trail / c - v.head_height * S / c, -v.head_height)
    joint = (v.rear_twist_distance * m.cos(v.rear_twist_angle) - v.rear_contact_distance,
             -v.rear_twist_distance * m.sin(v.rear_twist_angle))  # fmt: skip
    saddle = (-v.upper_body_distance, -v.upper_body_joint_height)
    slide = Freedom("head_slide_rate", "head_slide")
    twist = Freedom("head_twist_rate", "head_twist",
                    (m.cos(v.head_twist_inclination), -m.sin(v.head_twist_inclination)), head)  # fmt: skip
    steer = Freedom("steer_rate", "steer_angle", (S, c), head)
    assembly = Freedom("assembly_twist_rate", "assembly_twist",
                       (m.sin(v.rear_twist_inclination), m.cos(v.rear_twist_inclination)), joint)  # fmt: skip
    upper = Freedom("upper_body_rate", "upper_body_angle", (1, 0), saddle)
    front_x = v.front_contact_distance + (v.front_mass_offset + v.trail - v.front_mass_height * S) / c
    own, yaw_speed = front_inertia(v, m), v.speed / v.rear_wheel_radius
    return {
        "rear frame": Body(GROUND, v.frame_mass, (0, -v.frame_mass_height), v.frame_roll_inertia, v.frame_yaw_inertia,
                           v.frame_product_of_inertia, v.engine_spin_inertia * yaw_speed),
        "front frame": Body((*GROUND, slide, twist, steer), v.front_mass, (front_x, -v.front_mass_height), *own,
                            v.front_spin_inertia * v.speed / v.front_wheel_radius),
        "assembly": Body((*GROUND, assembly), v.assembly_mass, (-v.assembly_mass_distance, -v.assembly_mass_height),
                         v.assembly_inertia, v.assembly_inertia, 0, v.rear_spin_inertia * yaw_speed),
        "upper body": Body((*GROUND, upper), v.upper_body_mass,
                           (-v.upper_body_distance, -v.upper_body_joint_height - v.upper_body_rise),
                           v.upper_body_roll_inertia, v.upper_body_yaw_inertia, v.upper_body_product_of_inertia),
    }  # fmt: skip


def front_inertia(v: Any, m: Any) -> tuple[Any, Any, Any]:
    """Roll and yaw inertia of the front frame and the integral of x z dm about its mass centre, a rider's share
    included.
    """
    upright = v.front_steer_inertia + v.hands_on * (v.hands_steer_inertia - v.front_steer_inertia)
    C, D = m.cos(v.front_inertia_inclination), m.sin(v.front_inertia_inclination)
    c, S, share = m.cos(v.caster_angle), m.sin(v.caster_angle), v.added_steer_inertia
    x, xz = v.front_cross_inertia, v.front_product_of_inertia
    return (
        x * C**2 + upright * D**2 + 2 * xz * D * C + share * S**2,
        x * D**2 + upright * C**2 - 2 * xz * D * C + share * c**2,
        (x - upright) * D * C - xz * (C**2 - D**2) - share * S * c,
    )


def freedoms(body: dict[str, Body]) -> list[Freedom]:
    """Every freedom once, in the order of the states."""
    front, assembly, upper = (body[name].path for name in ("front frame", "assembly", "upper body"))
    return [*front, assembly[-1], upper[-1]]


def wheel_loads(v: Any, body: dict[str, Body]) -> dict[str, Any]:
    """The loads [N] on the front and the rear tyre."""
    wheelbase = v.front_contact_distance + v.rear_contact_distance
    weight = v.gravity * sum(b.mass for b in body.values())
    moment = v.gravity * sum(b.mass * (b.centre[0] + v.rear_contact_distance) for b in body.values())
    front = (moment - v.speed**2 * (v.drag * v.pressure_height + v.lift * wheelbase / 2)) / wheelbase
    return {"front": front, "rear": weight - v.lift * v.speed**2 - front}


def set_torques(v: Any) -> None:
    """Set the forces and torques of springs and dampers."""
    stiffness = v.steering_stiffness + v.hands_on * (v.hands_steering_stiffness - v.steering_stiffness)
    damping = v.steering_damping + v.hands_on * (v.hands_steering_damping - v.steering_damping)
    v.head_torque = stiffness * v.steer_angle + damping * v.steer_rate
    v.head_force = v.head_lateral_stiffness * v.head_slide + v.head_lateral_damping * v.head_slide_rate
    v.head_twist_torque = v.head_twist_stiffness * v.head_twist + v.head_twist_damping * v.head_twist_rate
    v.assembly_torque = v.assembly_twist_stiffness * v.assembly_twist + v.assembly_twist_damping * v.assembly_twist_rate
    v.upper_body_torque = v.upper_body_stiffness * v.upper_body_angle + v.upper_body_damping * v.upper_body_rate


def outer_force(j: Freedom, body: dict[str, Body], contacts: dict[str, Any], v: Any) -> Any:
    """The generalised force of weights, air and ground on a freedom, apart from the disturbances."""
    centre = ((v.front_contact_distance - v.rear_contact_distance) / 2, -v.pressure_height)
    frame, drag, lift = body["rear frame"].path, v.drag * v.speed**2, v.lift * v.speed**2
    resistance = v.front_load * (v.rolling_resistance + v.rolling_resistance_rise * v.speed**2)
    along = {"front": -resistance, "rear": drag + resistance}
    total = sum(vertical_force(j, b.path, b.centre, b.mass * v.gravity, v) for b in body.values())
    total += vertical_force(j, frame, centre, -lift, v)
    total -= v.longitudinal_forces * forward_force(j, frame, centre, drag, v)
    for end, (path, contact) in contacts.items():
        total += vertical_force(j, path, contact, -v[f"{end}_load"], v)
        total += side_force(j, path, contact, v[f"{end}_side_force"], v[f"{end}_overturning_moment"], v[f"{end}_yaw_moment"])
        total += v.longitudinal_forces * forward_force(j, path, contact, along[end], v, along_wheel=True)
    return total
