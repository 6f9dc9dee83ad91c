"""A vehicle's bodies (`vehicle_fmu.out_of_plane`) as an open kinematic tree in space, for Exudyn's ObjectKinematicTree.

Links: along, to the side, yaw, roll, then every further freedom after the one before it in a path, and the spinning
wheels. Axes are x forward, y right, z down.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vehicle_fmu.out_of_plane import Body

DOWN, RIGHT = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
Frames = tuple[list[np.ndarray], list[np.ndarray], list[np.ndarray]]  # orientation, joint, axis of each link


@dataclass(frozen=True)
class Link:
    """A link of the tree: name of its coordinate, parent, reference point and axis (3,), whether it slides."""

    name: str
    parent: int
    point: np.ndarray
    axis: np.ndarray
    slides: bool = False


@dataclass(frozen=True, eq=False)
class SpaceFreedom:
    """A freedom of a path that `vehicle_fmu.out_of_plane` does not have: name of its rate, point (x, z), axis (3,),
    whether it slides.
    """

    rate: str
    point: tuple[float, float]
    axis: np.ndarray
    slides: bool


class Tree:
    """The links of bodies, the front and the rear wheel last, whose polar inertias [kg.m2] are given.

    With pitch inertias of the other bodies [kg.m2] the tree moves in its plane too: vertically before yaw, in pitch
    after roll.
    """

    def __init__(self, body: Sequence[Body], front_spin_inertia: float, rear_spin_inertia: float,
                 pitch_inertias: Sequence[float] | None = None):  # fmt: skip
        self.body, self.polar, self.pitch_inertias = body, {"front": front_spin_inertia, "rear": rear_spin_inertia}, pitch_inertias
        self.links = _links(body, pitch_inertias is not None)
        self.place = {link.name: k for k, link in enumerate(self.links)}

    def frames(self, q: np.ndarray) -> Frames:
        """Orientation, joint and axis of each link, in fixed axes."""
        turned: list[np.ndarray] = []
        joints: list[np.ndarray] = []
        axes: list[np.ndarray] = []
        for link, x in zip(self.links, q, strict=True):
            before, joint, point = ((np.eye(3), np.zeros(3), np.zeros(3)) if link.parent < 0 else
                                     (turned[link.parent], joints[link.parent], self.links[link.parent].point))  # fmt: skip
            axes.append(before @ link.axis)
            joints.append(joint + before @ (link.point - point) + (axes[-1] * x if link.slides else 0.0))
            turned.append(before if link.slides else before @ _rotation(link.axis, x))
        return turned, joints, axes

    def path(self, name: str) -> list[int]:
        """The links from the ground to that of the name."""
        found, k = [], self.place[name]
        while k >= 0:
            found.append(k)
            k = self.links[k].parent
        return found[::-1]

    def force(self, path: Sequence[int], frames: Frames, point: np.ndarray, force: np.ndarray, moment: Any = 0.0) -> np.ndarray:
        """The generalised forces (n,) of a force at a point of the last link of a path, and of a moment on it."""
        _, joints, axes = frames
        total = np.zeros(len(self.links))
        for k in path:
            total[k] = axes[k] @ force if self.links[k].slides else axes[k] @ (np.cross(point - joints[k], force) + moment)
        return total

    def _pitch_inertia(self, k: int) -> float:
        """That of body k; any value does where no body pitches."""
        return self.pitch_inertias[k] if self.pitch_inertias else self.body[k].roll_inertia + self.body[k].yaw_inertia

    def arguments(self, exu: Any) -> dict[str, Any]:
        """The arguments of ObjectKinematicTree. The axis of a link is the third one of its own axes."""
        own = [_own_axes(link.axis) for link in self.links]
        mass, moment, second = np.zeros(len(self.links)), np.zeros((len(self.links), 3)), np.zeros((len(self.links), 3, 3))
        for k, part in enumerate(self.body):
            wheel = {len(self.body) - 2: "front", len(self.body) - 1: "rear"}.get(k)
            last = coordinate(part.path[-1].rate)
            link = self.place[f"{wheel}_spin" if wheel else "pitch" if last == "roll" and "pitch" in self.place else last]
            pitch = self.polar[wheel] if wheel else self._pitch_inertia(k)
            tensor = np.array([[part.roll_inertia, 0, -part.product], [0, pitch, 0], [-part.product, 0, part.yaw_inertia]], float)
            centre = np.array([part.centre[0], 0.0, part.centre[1]], float) - self.links[link].point
            mass[link] += part.mass
            moment[link] += part.mass * centre
            second[link] += tensor + part.mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        centres = moment / np.maximum(mass, 1e-300)[:, None]
        central = [about - m * (c @ c * np.eye(3) - np.outer(c, c)) for about, m, c in zip(second, mass, centres, strict=True)]
        before = [np.eye(3) if link.parent < 0 else own[link.parent] for link in self.links]
        points = [np.zeros(3) if link.parent < 0 else self.links[link.parent].point for link in self.links]
        return {
            "jointTypes": [exu.JointType.PrismaticZ if link.slides else exu.JointType.RevoluteZ for link in self.links],
            "linkParents": [link.parent for link in self.links],
            "jointTransformations": exu.Matrix3DList([b.T @ o for b, o in zip(before, own, strict=True)]),
            "jointOffsets": exu.Vector3DList([b.T @ (link.point - x) for b, link, x in zip(before, self.links, points, strict=True)]),
            "linkInertiasCOM": exu.Matrix3DList([o.T @ each @ o for o, each in zip(own, central, strict=True)]),
            "linkCOMs": exu.Vector3DList([o.T @ c for o, c in zip(own, centres, strict=True)]),
            "linkMasses": list(mass),
        }


def is_rate(name: str) -> bool:
    return name.endswith(("_rate", "_velocity"))


def coordinate(name: str) -> str:
    """The coordinate of the tree that a state is, or is the rate of."""
    for ending in ("_rate", "_velocity", "_angle", "_position"):
        name = name.removesuffix(ending)
    return name


def _links(body: Sequence[Body], in_space: bool) -> list[Link]:
    """Along, then every freedom after the one before it in a path, then the spinning wheels."""
    links = [Link("along", -1, np.zeros(3), np.array([1.0, 0.0, 0.0]), True)]
    place: dict[int, int] = {}
    for part in body:
        path: Sequence[Any] = part.path
        for k, j in enumerate(path):
            if id(j) in place:
                continue
            parent = place[id(part.path[k - 1])] if k else 0
            slides = j.slides if isinstance(j, SpaceFreedom) else j.axis is None
            axis = _axis(j)
            if in_space and j.rate == "yaw_rate":
                links.append(Link("vertical", parent, np.zeros(3), DOWN, True))
                parent = len(links) - 1
            place[id(j)] = len(links)
            links.append(Link(coordinate(j.rate), parent, np.array([j.point[0], 0.0, j.point[1]], float), axis, slides))
            if in_space and j.rate == "roll_rate":
                place[id(j)] = len(links)
                links.append(Link("pitch", len(links) - 1, np.zeros(3), RIGHT))
    for wheel, part in (("front", body[-2]), ("rear", body[-1])):
        centre = np.array([part.centre[0], 0.0, part.centre[1]], float)
        links.append(Link(f"{wheel}_spin", place[id(part.path[-1])], centre, -RIGHT))
    return links


def _axis(freedom: Any) -> np.ndarray:
    if isinstance(freedom, SpaceFreedom):
        return freedom.axis
    return RIGHT if freedom.axis is None else np.array([freedom.axis[0], 0.0, freedom.axis[1]], float)


def _own_axes(axis: np.ndarray) -> np.ndarray:
    """A rotation matrix (3, 3) whose third column is the axis."""
    first = np.cross(axis, [0.3, 0.5, 0.8])
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(axis, first), axis])


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """The rotation (3, 3) about a unit axis (Rodrigues)."""
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
