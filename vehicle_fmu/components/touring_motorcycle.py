r"""A touring motorcycle with flexible frame, fork and swingarm, and a rider who leans and slides, in straight running.

Bodies: frame; swingarm; rear wheel; rider's lower and upper body; upper fork with the handlebar; lower fork; front
wheel. Freedoms, in the order of `vehicle_fmu.out_of_plane`, whose equations apply; each can be locked by its switch s
(0):

    v, r, phi                              lateral velocity, yaw rate, roll about the line through the contacts
    beta    (all of the fork)              frame torsion about the axis (cos eps, -sin eps) through the steering head
    delta   (all of the fork)              steer about the axis (sin eps, cos eps) through the steering head; damper K
    mu      (lower fork, front wheel)      fork bending about the axis (cos eps, -sin eps) through the fork's joint
    nu      (lower fork, front wheel)      fork torsion about the axis (sin eps, cos eps) through the fork's joint
    lambda  (swingarm, rear wheel)         swingarm torsion about an axis along x through the swingarm's pivot
    y_r     (lower and upper body)         slide of the rider on the saddle
    zeta    (upper body)                   lean about the axis (cos theta, sin theta) through the lower body's mass centre

Each has a stiffness and a damping. The tyres are those of `vehicle_fmu.magic_formula_tyres`. With the wheelbase w, drag
D V^2 and lift L V^2 at the reference point (height h_0 above the origin), and a pitching moment M V^2 that lifts the
front:

    w Z_f = g sum m_i (b + x_i) - V^2 (D h_0 + L b + M),       Z_r = g sum m_i - L V^2 - Z_f

The rear tyre drives with D V^2 along its heading, r_c gamma beside the lowest point of a disc. Suspensions keep their
position. Points are given as (x, z), x forward and z up, each from the reference point or the mass centre that its
description names.

A rider at the handlebar port replaces the yaw freedom of the paper's rider, which is the passive rider of 2011. The
torques of the port act as in Sharp's motorcycle of 1971.

Source: Passigato, Eisele, Wisselmann, Gordner, Diermeyer, Applied Sciences 10 (2020) 6826, and its open model. The
equations are derived here; the tests derive them a second time with Kane's equations.
"""

from collections.abc import Iterator
from typing import Any, ClassVar

from fmus import local, parameter, state
from fmus.declaration.elements import Element
from fmus.declaration.variables import Variable
from vehicle_fmu.magic_formula_tyres import MagicFormulaTyres, set_tyre
from vehicle_fmu.out_of_plane import (
    GROUND,
    Body,
    Freedom,
    forward_force,
    heading,
    held,
    inertia_force,
    lateral_velocity,
    mass_matrix,
    side_force,
    tilt,
    vertical_force,
)
from vehicle_fmu.steered_vehicle import SteeredOnTyres, port_motion, port_torques

POINTS = {  # symbol, meaning
    "frame": ("F", "Reference point from the frame's mass centre"),
    "lower_body": ("B", "Mass centre of the lower body from the reference point"),
    "steering_head": ("H", "Steering head from the reference point"),
    "swingarm_axis": ("A", "Pivot of the swingarm from the reference point"),
    "upper_body_joint": ("U", "Joint of the upper body from its mass centre, in axes that lean with it"),
    "upper_fork": ("G", "Mass centre of the upper fork from the steering head"),
    "fork_joint": ("J", "Joint of the fork from the mass centre of the upper fork"),
    "lower_fork_joint": ("L", "Joint of the fork from the mass centre of the lower fork"),
    "front_wheel_centre": ("W", "Centre of the front wheel from the mass centre of the lower fork"),
    "swingarm_joint": ("S", "Pivot of the swingarm from the swingarm's mass centre"),
    "rear_wheel_centre": ("R", "Centre of the rear wheel from the swingarm's mass centre"),
}
BODIES = {  # symbol, name of the body
    "frame": ("F", "frame"),
    "lower_body": ("B", "rider's lower body"),
    "upper_body": ("U", "rider's upper body"),
    "upper_fork": ("G", "upper fork with the handlebar"),
    "lower_fork": ("L", "lower fork"),
    "front_wheel": ("W", "front wheel"),
    "swingarm": ("S", "swingarm"),
    "rear_wheel": ("R", "rear wheel"),
}
FLEXIBLE = {  # name: symbol, what it is, name of its torque or force, is it a slide
    "frame_torsion": (r"\beta", "torsion of the frame", False),
    "fork_bending": (r"\mu", "bending of the fork", False),
    "fork_torsion": (r"\nu", "torsion of the fork", False),
    "swingarm_torsion": (r"\lambda", "torsion of the swingarm", False),
    "rider_slide": ("y", "slide of the rider", True),
    "rider_lean": (r"\zeta", "lean of the upper body", False),
}


def rows() -> Iterator[tuple[str, Variable]]:
    """Points, bodies and flexible freedoms."""
    for name, (mark, meaning) in POINTS.items():
        for axis, direction in (("x", "forward"), ("z", "up")):
            yield f"{name}_{axis}", parameter("m", f"{meaning}, {direction}", symbol=f"{axis}_{mark}", min=-10, max=10)
    for name, (mark, body) in BODIES.items():
        yield f"{name}_mass", parameter("kg", f"Mass of the {body}", symbol=f"m_{mark}", min=1e-6, max=1e5, start=10.0)
        for axes, word in (("xx", "roll inertia"), ("zz", "yaw inertia"), ("xz", "tensor element x z")):
            least, start = (-1e5, 0.0) if axes == "xz" else (1e-9, 1.0)
            yield f"{name}_{axes}", parameter("kg.m2", f"{word.capitalize()} of the {body}, z up", symbol=f"I_{{{mark}{axes}}}",
                                              min=least, max=1e5, start=start)  # fmt: skip
    for name, (symbol, what, is_slide) in FLEXIBLE.items():
        unit, torque, per = ("m", "N", "m") if is_slide else ("rad", "N.m", "rad")
        yield name, parameter("1", f"Whether the {what} is free (1) or locked (0)", symbol=f"s_{{{symbol}}}", min=0,
                              max=1, start=1)  # fmt: skip
        yield f"{name}_stiffness", parameter(f"{torque}/{per}", f"Stiffness of the {what}", symbol=f"k_{{{symbol}}}", min=0,
                                             max=1e15, start=1e5)  # fmt: skip
        yield f"{name}_damping", parameter(f"{torque}.s/{per}", f"Damping of the {what}", symbol=f"c_{{{symbol}}}", min=0,
                                           max=1e9, start=20.0)  # fmt: skip
        yield f"{name}_rate", state(f"{unit}/s", f"Rate of the {what}", symbol=rf"\dot {symbol}")
        yield f"{name}_position", state(unit, f"{what.capitalize()}, to the right", symbol=symbol, nominal=1e-2)
        yield f"{name}_reaction", local(torque, f"Reaction of the {what}", symbol=f"Q_{{{symbol}}}")


class TouringMotorcycle(SteeredOnTyres, MagicFormulaTyres):
    """Touring motorcycle with flexible frame, fork and swingarm, a moving rider and Magic Formula tyres."""

    vars().update(rows())
    reference_height = parameter("m", "Height of the reference point", symbol="h_0", min=0, max=5, start=0.5)
    upper_body_inclination = parameter("rad", "Forward inclination of the axes of the upper body and of its lean axis",
                                       symbol=r"\theta", min=-1.5, max=1.5)  # fmt: skip
    upper_body_inertia_inclination = parameter("rad", "Forward inclination of the axes of the upper body's inertia",
                                               symbol=r"\theta_I", min=-1.6, max=1.6)  # fmt: skip
    drag = parameter("N.s2/m2", "Drag per squared speed", symbol="D", min=0, max=10)
    lift = parameter("N.s2/m2", "Lift per squared speed", symbol="L", min=-10, max=10)
    pitching_moment = parameter("N.s2/m", "Pitching moment per squared speed, lifting the front", symbol="M", min=-10, max=10)



    elements: ClassVar = {
        **SteeredOnTyres.elements,
        **{name: Element(f"{name}_reaction", f"{name}_position", f"{name}_rate", f"{name}_stiffness", f"{name}_damping")
           for name in FLEXIBLE},
    }  # fmt: skip

    def mass(self, v, m):
        body, freedoms = bodies(v, m)
        return mass_matrix(body, freedoms)

    def equations(self, v, m):
        body, freedoms = bodies(v, m)
        contacts = {end: (body[place].path, (body[place].centre[0], 0)) for end, place in (("front", -2), ("rear", -1))}
        derivatives: dict[str, Any] = {}
        for end, load in wheel_loads(v, body).items():
            path, contact = contacts[end]
            slip = heading(path, v) - lateral_velocity(path, contact, v) / v.speed
            derivatives |= set_tyre(v, m, end, load, slip, tilt(path, v))
        v.head_torque = v.steering_damping * v.steer_rate
        own = port_torques(v, m)
        for name in FLEXIBLE:
            reaction = v[f"{name}_stiffness"] * v[f"{name}_position"] + v[f"{name}_damping"] * v[f"{name}_rate"]
            setattr(v, f"{name}_reaction", reaction)
        for place, j in enumerate(freedoms):
            name = j.rate.removesuffix("_rate")
            force = held(j, v[f"{name}_reaction"], v, place) if name in FLEXIBLE else own[j.rate]
            for end, (path, contact) in contacts.items():
                force += side_force(j, path, contact, derivatives[f"{end}_side_force"], v[f"{end}_overturning_moment"],
                                    v[f"{end}_yaw_moment"])  # fmt: skip
            derivatives[f"der({j.rate})"] = force + inertia_force(j, body, v) + steady_force(j, body, contacts, v)
            if j.angle:
                derivatives[f"der({j.angle})"] = v[j.rate]
        return {**derivatives, **port_motion(v, m)}


def bodies(v: Any, m: Any) -> tuple[list[Body], list[Freedom]]:
    """The bodies, the wheels last, and the freedoms in the order of the docstring. z is down from here on."""
    c, S = m.cos(v.caster_angle), m.sin(v.caster_angle)
    C, D = m.cos(v.upper_body_inclination), m.sin(v.upper_body_inclination)

    def point(name: str, base: tuple[Any, Any], sign: int = 1) -> tuple[Any, Any]:
        return base[0] + sign * v[f"{name}_x"], base[1] - sign * v[f"{name}_z"]

    reference = (0, -v.reference_height)
    head, pivot, saddle = (point(name, reference) for name in ("steering_head", "swingarm_axis", "lower_body"))
    upper_fork = point("upper_fork", head)
    joint = point("fork_joint", upper_fork)
    lower_fork = point("lower_fork_joint", joint, -1)
    front_wheel = point("front_wheel_centre", lower_fork)
    swingarm = point("swingarm_joint", pivot, -1)
    rear_wheel = point("rear_wheel_centre", swingarm)
    upper_body = (saddle[0] - C * v.upper_body_joint_x - D * v.upper_body_joint_z,
                  saddle[1] - D * v.upper_body_joint_x + C * v.upper_body_joint_z)  # fmt: skip

    def hinge(name: str, axis: tuple[Any, Any] | None, at: tuple[Any, Any] = (0, 0)) -> Freedom:
        return Freedom(f"{name}_rate", f"{name}_position", axis, at, v[name])

    frame_torsion = hinge("frame_torsion", (c, -S), head)
    steer = Freedom("steer_rate", "steer_angle", (S, c), head)
    bending, torsion = hinge("fork_bending", (c, -S), joint), hinge("fork_torsion", (S, c), joint)
    swing = hinge("swingarm_torsion", (1, 0), pivot)
    slide, lean = hinge("rider_slide", None), hinge("rider_lean", (C, D), saddle)
    fork = (*GROUND, frame_torsion, steer)
    front, rear, rider = (*fork, bending, torsion), (*GROUND, swing), (*GROUND, slide)

    def body(name: str, path: tuple[Freedom, ...], centre: tuple[Any, Any], inclination: tuple[Any, Any] = (1, 0),
             share: Any = 0, spin: Any = None) -> Body:  # fmt: skip
        """A body whose inertia is given in axes that lean forward by an angle of that cosine and sine."""
        k, n = inclination
        x, z, xz = (v[f"{name}_{axes}"] for axes in ("xx", "zz", "xz"))
        return Body(path, v[f"{name}_mass"], centre,
                    x * k**2 + z * n**2 + 2 * xz * k * n + share * S**2,
                    x * n**2 + z * k**2 - 2 * xz * k * n + share * c**2,
                    (z - x) * k * n + xz * (k**2 - n**2) - share * S * c, spin)  # fmt: skip

    own = (m.cos(v.upper_body_inertia_inclination), m.sin(v.upper_body_inertia_inclination))
    return [
        body("frame", GROUND, point("frame", reference, -1)),
        body("lower_body", rider, saddle),
        body("upper_body", (*rider, lean), upper_body, own),
        body("upper_fork", fork, upper_fork, (c, -S), v.added_steer_inertia),
        body("lower_fork", front, lower_fork, (c, -S)),
        body("swingarm", rear, swingarm),
        body("front_wheel", front, front_wheel, spin=v.front_spin_inertia * v.speed / v.front_wheel_radius),
        body("rear_wheel", rear, rear_wheel, spin=v.rear_spin_inertia * v.speed / v.rear_wheel_radius),
    ], [*front, swing, slide, lean]


def wheel_loads(v: Any, body: list[Body]) -> dict[str, Any]:
    """The loads [N] on the front and the rear tyre."""
    behind = -body[-1].centre[0]
    wheelbase = body[-2].centre[0] + behind
    weight = v.gravity * sum(b.mass for b in body)
    moment = v.gravity * sum(b.mass * (b.centre[0] + behind) for b in body)
    lifted = v.drag * v.reference_height + v.lift * behind + v.pitching_moment
    front = (moment - v.speed**2 * lifted) / wheelbase
    return {"front": front, "rear": weight - v.lift * v.speed**2 - front}


def steady_force(j: Freedom, body: list[Body], contacts: dict[str, Any], v: Any) -> Any:
    """The generalised force of weights, loads, lift, drag and drive on a freedom."""
    reference, drag = (0, -v.reference_height), v.drag * v.speed**2
    total = sum(vertical_force(j, b.path, b.centre, b.mass * v.gravity, v) for b in body)
    total += vertical_force(j, GROUND, reference, -v.lift * v.speed**2, v) - forward_force(j, GROUND, reference, drag, v)
    for end, (path, contact) in contacts.items():
        total += vertical_force(j, path, contact, -v[f"{end}_load"], v)
    path, contact = contacts["rear"]
    turning = -v.rear_section_radius * v.rear_camber_angle * drag
    return total + forward_force(j, path, contact, drag, v, along_wheel=True) + side_force(j, path, contact, 0, 0, turning)
