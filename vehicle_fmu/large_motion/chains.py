"""The touring motorcycle's links and bodies in axes of its frame, at coordinates and rates.

Freedoms, joints and axes are those of `vehicle_fmu.large_motion.touring_tree`, all free: the fork twists with the
frame, steers, bends to the side and lengthwise, twists, and its lower part slides; the swingarm turns about its pivot
and twists; the rider slides and leans. Lower fork and front wheel, swingarm and rear wheel are one body each, to which
the wheel's spin adds a momentum.

Down D, heading X and right of the heading H have, in axes of the frame, at roll phi and pitch theta, the components

    X = (cos theta, 0, sin theta),    H = (sin theta sin phi, cos phi, -cos theta sin phi),
    D = (-sin theta cos phi, sin phi, cos theta cos phi)

A has the velocity u X + v H + w D, the frame the angular velocity r D + p X + q (0, 1, 0); these components change with
the frame's rotation against the heading, p X + q (0, 1, 0).

Source: as in `vehicle_fmu.components.touring_motorcycle`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vehicle_fmu.components import touring_motorcycle
from vehicle_fmu.large_motion.frame_axes import (
    ZERO,
    Body,
    Inertia,
    Link,
    Solid,
    Twist,
    Vector,
    body,
    cross,
    once,
    plus,
    times,
    total,
)
from vehicle_fmu.large_motion.suspension import FRONT, LENGTHWISE, REAR
from vehicle_fmu.large_motion.touring_tree import ENDS, ORDER, named_values

RIGHT: Vector = (0, 1, 0)
UPRIGHT: tuple[Vector, Vector, Vector] = ((1, 0, 0), RIGHT, (0, 0, 1))
FRAME = ("forward_speed", "lateral_velocity", "vertical_velocity", "yaw_rate", "roll_rate", "pitch_rate")
FORK = ("frame_torsion", "steer", "fork_bending", LENGTHWISE, "fork_torsion", FRONT)
CHAINS = (FORK, (REAR, "swingarm_torsion"), ("rider_slide", "rider_lean"))
CARRIER = {"front": FRONT, "rear": "swingarm_torsion"}  # the link that carries the wheel
CARRIED = {  # bodies that a link carries beside those of the links that it carries
    FRONT: ("lower_fork",),
    "steer": ("upper_fork",),
    "swingarm_torsion": ("swingarm",),
    "rider_lean": ("upper_body",),
    "rider_slide": ("lower_body",),
}


@dataclass(frozen=True)
class Posed:
    """The motorcycle at a moment: directions X, H, D and twists of the frame's rates; links by the name of their
    freedom, `frame` among them; bodies by name; wheels' centres, heights upright and spin momenta by end.
    """

    ahead: Vector
    right: Vector
    down: Vector
    of_frame: dict[str, Twist]
    links: dict[str, Link]
    bodies: dict[str, Body]
    centre: dict[str, Vector]
    height: dict[str, Any]
    spin_momentum: dict[str, Vector]

    def path(self, name: str) -> dict[str, Twist]:
        """The twists of the freedoms on the path to a link, its own the last, by the rates' names."""
        chain = next(chain for chain in CHAINS if name in chain)
        return {**self.of_frame, **{f"{n}_rate": self.links[n].freedom for n in chain[: chain.index(name) + 1]}}

    def inertia(self, m: Any) -> dict[str, Inertia]:
        """The inertia of all that a link carries, by the name of its freedom, and of all: `frame`."""
        found, whole = {}, [self.bodies["frame"].inertia]
        for chain in CHAINS:
            so_far: list[Inertia] = []
            for name in reversed(chain):
                so_far += [self.bodies[b].inertia for b in CARRIED.get(name, ())]
                found[name] = total(so_far, m)
            whole.append(found[chain[0]])
        return {**found, "frame": total(whole, m)}


def posed(v: Mapping[str, Any], m: Any) -> Posed:
    """The motorcycle at the values v of its parameters and states."""
    ahead, right, down = directions(v, m)
    of_frame = {name: Twist(ZERO, axis) for name, axis in zip(FRAME[:3], (ahead, right, down), strict=True)}
    of_frame |= {name: Twist(axis, ZERO) for name, axis in zip(FRAME[3:], (down, ahead, RIGHT), strict=True)}
    frame = _frame(v, m, ahead, right, down)
    links = {"frame": frame}
    found, _ = touring_motorcycle.bodies(named_values(v), m)
    points = dict(zip(ORDER, ((b.centre[0], b.centre[1]) for b in found), strict=True))
    axes = {
        "fork": (m.term(m.cos(v["caster_angle"])), m.term(m.sin(v["caster_angle"]))),
        "rider": (m.term(m.cos(v["upper_body_inclination"])), m.term(-m.sin(v["upper_body_inclination"]))),
        "": (1, 0),
    }
    head, pivot, joint = (_joint(v, points, name) for name in ("steering_head", "swingarm_axis", "fork_joint"))

    def state(name: str) -> tuple[Any, Any]:
        return v["steer_angle" if name == "steer" else f"{name}_position"], v[f"{name}_rate"]

    link = _fixed(frame, head, axes["fork"])
    to_joint = _offset(joint, head, axes["fork"])
    for name, about, offset in (
        ("frame_torsion", 0, ZERO),
        ("steer", 2, ZERO),
        ("fork_bending", 0, to_joint),
        (LENGTHWISE, 1, ZERO),
        ("fork_torsion", 2, ZERO),
    ):
        link = links[name] = link.turned(m, about, *state(name), offset)
    links[FRONT] = link.slid(m, 2, *state(FRONT), sign=-1)
    links[REAR] = _fixed(frame, pivot, axes[""]).turned(m, 1, *state(REAR), sign=-1)
    links["swingarm_torsion"] = links[REAR].turned(m, 0, *state("swingarm_torsion"))
    saddle = points["lower_body"]
    links["rider_slide"] = _fixed(frame, saddle, axes["rider"]).slid(m, 1, *state("rider_slide"))
    links["rider_lean"] = links["rider_slide"].turned(m, 0, *state("rider_lean"))
    solids = {}
    for name, base, which, place in (
        ("frame", "frame", "", (0, 0)),
        ("upper_fork", "steer", "fork", head),
        ("lower_fork", FRONT, "fork", joint),
        ("front_wheel", FRONT, "fork", joint),
        ("swingarm", "swingarm_torsion", "", pivot),
        ("rear_wheel", "swingarm_torsion", "", pivot),
        ("lower_body", "rider_slide", "rider", saddle),
        ("upper_body", "rider_lean", "rider", saddle),
    ):
        end = name.removesuffix("_wheel")
        pitch = v[f"{end}_spin_inertia" if end in ENDS else f"{name}_yy"]
        solids[name] = _solid(found[ORDER.index(name)], pitch, place, axes[which], m), links[base]
    whole = {
        "frame": solids["frame"],
        **{n: solids[n] for n in ("upper_fork", "lower_body", "upper_body")},
        "lower_fork": (solids["lower_fork"][0].joined(solids["front_wheel"][0], m), links[FRONT]),
        "swingarm": (solids["swingarm"][0].joined(solids["rear_wheel"][0], m), links["swingarm_torsion"]),
    }
    centre, momentum = {}, {}
    for end in ENDS:
        solid, link = solids[f"{end}_wheel"]
        centre[end] = once(m, link.place((solid.offset[0], 0, solid.offset[1])))
        momentum[end] = once(m, times(-v[f"{end}_spin_inertia"] * v[f"{end}_spin_rate"], link.axes[1]))
    bodies = {name: body(solid, link, m) for name, (solid, link) in whole.items()}
    height = {end: m.term(-points[f"{end}_wheel"][1]) for end in ENDS}
    return Posed(ahead, right, down, of_frame, links, bodies, centre, height, momentum)


def directions(v: Mapping[str, Any], m: Any) -> tuple[Vector, Vector, Vector]:
    """X, H and D in axes of the frame."""
    c, s = m.term(m.cos(v["pitch_angle"])), m.term(m.sin(v["pitch_angle"]))
    C, S = m.term(m.cos(v["roll_angle"])), m.term(m.sin(v["roll_angle"]))
    return (c, 0, s), once(m, (s * S, C, -c * S)), once(m, (-s * C, S, c * C))


def _frame(v: Mapping[str, Any], m: Any, ahead: Vector, right: Vector, down: Vector) -> Link:
    u, lateral, vertical, r, p, q = (v[name] for name in FRAME)
    relative = once(m, plus(times(p, ahead), times(q, RIGHT)))
    velocity = once(m, plus(times(u, ahead), times(lateral, right), times(vertical, down)))
    turning = times(r, down)
    changed = plus(cross(turning, relative), times(p, cross(ahead, times(q, RIGHT))))
    acceleration = Twist(changed, cross(velocity, relative)).once(m)
    return Link(UPRIGHT, ZERO, Twist(ZERO, ZERO), Twist(once(m, plus(turning, relative)), velocity), acceleration)


def _fixed(frame: Link, place: tuple[Any, Any], axes: tuple[Any, Any]) -> Link:
    """Axes that are fixed in the frame, at a point (x, z) of it: the first one is (k, -n), the third one (n, k)."""
    k, n = axes
    basis: tuple[Vector, Vector, Vector] = ((k, 0, -n), RIGHT, (n, 0, k))
    return Link(basis, (place[0], 0, place[1]), frame.freedom, frame.twist, frame.acceleration)


def _offset(point: tuple[Any, Any], base: tuple[Any, Any], axes: tuple[Any, Any]) -> Vector:
    (k, n), x, z = axes, point[0] - base[0], point[1] - base[1]
    return (k * x - n * z, 0, n * x + k * z)


def _solid(b: Any, pitch: Any, base: tuple[Any, Any], axes: tuple[Any, Any], m: Any) -> Solid:
    """A body in axes of its link."""
    (k, n), x, z, product = axes, b.roll_inertia, b.yaw_inertia, b.product
    offset = _offset(b.centre, base, axes)
    roll, yaw = x * k**2 + z * n**2 + 2 * product * k * n, x * n**2 + z * k**2 - 2 * product * k * n
    mixed = (z - x) * k * n + product * (k**2 - n**2)
    return Solid(b.mass, (m.term(offset[0]), m.term(offset[2])), m.term(roll), pitch, m.term(yaw), m.term(mixed))


def _joint(v: Mapping[str, Any], points: Mapping[str, Any], name: str) -> tuple[Any, Any]:
    """Steering head and swingarm's pivot from the reference point; the fork's joint from the upper fork's mass
    centre.
    """
    x, z = points["upper_fork"] if name == "fork_joint" else (0, -v["reference_height"])
    return x + v[f"{name}_x"], z - v[f"{name}_z"]
