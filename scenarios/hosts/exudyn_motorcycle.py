"""Exudyn: the touring motorcycle of 2020 as rigid bodies in space, alone and with the FMU of a rider at its handlebar.

The bodies are links of a kinematic tree (ObjectKinematicTree): along, to the side, yaw, roll, then each flexible freedom and
the steer, and the spinning wheels. Exudyn forms inertia and gyroscopic forces in full motion. The forces are given here in
full motion too: springs, loads at the lowest points of the wheels, drag and drive, and the tyres, whose relaxed slip angles
are states of a first-order object (ObjectGenericODE1). Nothing is linearised: states are so small that their squares do not
show. From the motion out of every state alone over INTERVAL follows the transition matrix, and from it every eigenvalue;
they are compared with those of `vehicle_fmu`.

Axes are x forward, y right, z down. The FMU steps in the pre-step function and is asked in the force function (see
`motofmi.scenarios.hosts.device`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import numpy as np

from fmus import Component, linearise
from fmus.export.build import build
from fmus.expressions.functions import NUMERIC
from motofmi.scenarios.hosts.device import Device
from motofmi.scenarios.hosts.table import main
from rider_fmu import riders
from vehicle_fmu import motorcycles, ridden
from vehicle_fmu.components.touring_motorcycle import FLEXIBLE, bodies

HOST, PACKAGE = "Exudyn", "exudyn"
SMALL = 1e-5  # of the unit of each state; what is not linear is this squared
INTERVAL = 0.004  # s, below half the period of the fastest mode
DOWN, RIGHT = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
TYRES = ("front_relaxed_slip", "rear_relaxed_slip")


def run(speed: float = 30.0, step: float = 5e-4, duration: float = 1.0, rider: str = "mean_2011") -> dict[str, float]:
    """The largest error of an eigenvalue of the motorcycle, and of its motion with the rider's FMU after a push, as shares.

    speed [m/s], step and duration [s]. Raises ModuleNotFoundError without Exudyn.
    """
    motorcycle, device = motorcycles.load("tum_2020"), riders.load(rider)
    ours = np.linalg.eigvals(linearise(motorcycle, speed=speed).A)
    theirs = eigenvalues(motorcycle, speed, step)
    held = motorcycle.with_values(added_steer_inertia=device.run(device.start_values(), NUMERIC)["port_inertia"])
    with TemporaryDirectory() as folder:
        holding = Device(build(device, folder).path, Path(folder, "rider"))
        found = motion(held, speed, step, duration, {"steer_rate": SMALL}, holding)
        holding.close()
    space = linearise(ridden(motorcycle, device), **{"vehicle.speed": speed})
    exact = exact_motion(space, {"vehicle.steer_rate": SMALL}, step, len(found))
    columns = [space.states.index(f"vehicle.{name}") for name in ("roll_angle", "steer_angle")]
    own = [names(held).index(name) for name in ("roll_angle", "steer_angle")]
    errors = np.abs(found[:, own] - exact[:, columns]).max(axis=0) / np.abs(exact[:, columns]).max(axis=0)
    return {"largest_eigenvalue_error": max(float(np.abs(theirs - z).min() / abs(z)) for z in ours),
            "roll_error_with_rider": float(errors[0]), "steer_error_with_rider": float(errors[1])}  # fmt: skip


def eigenvalues(motorcycle: Component, speed: float, step: float = 5e-4) -> np.ndarray:
    """The eigenvalues (n,) [1/s] of the multibody motorcycle in straight running at a speed [m/s]."""
    own = names(motorcycle)
    columns = [motion(motorcycle, speed, step, INTERVAL, {name: SMALL})[-1] / SMALL for name in own]
    return np.log(np.linalg.eigvals(np.column_stack(columns)).astype(complex)) / INTERVAL


def names(motorcycle: Component) -> list[str]:
    """The states that are compared: all of the component."""
    return list(motorcycle.states)


def exact_motion(space: Any, start: dict[str, float], step: float, count: int) -> np.ndarray:
    """States (count, n) of a linear system from initial values by name."""
    from scipy.linalg import expm  # noqa: PLC0415 - imported on use

    state, over = np.array([start.get(name, 0.0) for name in space.states]), expm(space.A * step)
    rows = [state]
    for _ in range(count - 1):
        rows.append(over @ rows[-1])
    return np.array(rows)


def motion(motorcycle: Component, speed: float, step: float, duration: float, start: dict[str, float],
           device: Device | None = None) -> np.ndarray:  # fmt: skip
    """The states (n, nx) at all steps from initial values by name."""
    import exudyn as exu  # noqa: PLC0415 - an optional package

    mbs = exu.SystemContainer().AddSystem()
    vehicle = MultibodyMotorcycle(exu, mbs, motorcycle, speed, start, device)
    rows: list[np.ndarray] = []

    def at_start_of_step(mbs: Any, end_of_step: float) -> bool:
        if device is not None:
            device.meet(len(rows) * step, vehicle.handlebar(*vehicle.coordinates()))
        rows.append(vehicle.states())
        return True

    mbs.SetPreStepUserFunction(at_start_of_step)
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(duration / step)
    settings.timeIntegration.endTime = duration
    settings.timeIntegration.verboseMode = 0
    settings.solution.file.write = False
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44)
    return np.array([*rows, vehicle.states()])


@dataclass(frozen=True)
class Link:
    """A link of the tree: name of its coordinate, parent, reference point and axis (3,), whether it slides."""

    name: str
    parent: int
    point: np.ndarray
    axis: np.ndarray
    slides: bool = False


class MultibodyMotorcycle:
    """The motorcycle in an Exudyn system, running straight ahead."""

    def __init__(self, exu: Any, mbs: Any, motorcycle: Component, speed: float, start: dict[str, float], device: Device | None):
        self.mbs, self.speed, self.device, self.component = mbs, speed, device, motorcycle
        self.at_speed = motorcycle.run({**motorcycle.start_values(), "speed": speed}, NUMERIC)
        self.p = SimpleNamespace(**motorcycle.values)
        body, freedoms = bodies(_Values({**motorcycle.values, "speed": speed}), NUMERIC)
        self.links = _links(freedoms, body)
        self.place = {link.name: k for k, link in enumerate(self.links)}
        zero = np.zeros(len(self.links))
        position, rate = zero.copy(), zero.copy()
        rate[self.place["along"]] = speed
        for wheel, radius in (("front", self.p.front_wheel_radius), ("rear", self.p.rear_wheel_radius)):
            rate[self.place[f"{wheel}_spin"]] = speed / radius
        for name, value in start.items():
            if name not in TYRES:
                (rate if _is_rate(name) else position)[self.place[_coordinate(name)]] = value
        slips = [start.get(name, 0.0) for name in TYRES]
        from exudyn.itemInterface import (  # noqa: PLC0415 - an optional package
            NodeGenericODE1,
            NodeGenericODE2,
            ObjectGenericODE1,
            ObjectKinematicTree,
        )

        node = mbs.AddNode(NodeGenericODE2(referenceCoordinates=zero, initialCoordinates=position, initialCoordinates_t=rate,
                                           numberOfODE2Coordinates=len(zero)))  # fmt: skip
        self.slip_node = mbs.AddNode(NodeGenericODE1(referenceCoordinates=[0.0, 0.0], initialCoordinates=slips,
                                                     numberOfODE1Coordinates=2))  # fmt: skip
        self.node, self.kind = node, exu.OutputVariableType
        mbs.AddObject(ObjectKinematicTree(nodeNumber=node, gravity=[0.0, 0.0, self.p.gravity], forceUserFunction=self.forces,
                                          **_tree(exu, self.links, body, self.p)))  # fmt: skip
        mbs.AddObject(ObjectGenericODE1(nodeNumbers=[self.slip_node], rhsUserFunction=self.slip_rates))

    # State ------------------------------------------------------------------------------------------

    def coordinates(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (n,) of the links."""
        return (np.asarray(self.mbs.GetNodeOutput(self.node, self.kind.Coordinates)),
                np.asarray(self.mbs.GetNodeOutput(self.node, self.kind.Coordinates_t)))  # fmt: skip

    def states(self) -> np.ndarray:
        """The states of the component; the lateral velocity is to the right of the moving axes."""
        q, w = self.coordinates()
        slips = np.asarray(self.mbs.GetNodeOutput(self.slip_node, self.kind.Coordinates))
        yaw = q[self.place["yaw"]]
        own = dict(zip(TYRES, slips, strict=True))
        own["lateral_velocity"] = -np.sin(yaw) * w[self.place["along"]] + np.cos(yaw) * w[self.place["lateral"]]
        return np.array([own[name] if name in own else (w if _is_rate(name) else q)[self.place[_coordinate(name)]]
                         for name in self.component.states])  # fmt: skip

    # Kinematics -------------------------------------------------------------------------------------

    def frames(self, q: np.ndarray) -> tuple[list[np.ndarray], list[np.ndarray], list[np.ndarray]]:
        """Orientation, origin and axis of each link, in fixed axes."""
        turned: list[np.ndarray] = []
        origins: list[np.ndarray] = []
        axes: list[np.ndarray] = []
        for link, x in zip(self.links, q, strict=True):
            before, origin, point = ((np.eye(3), np.zeros(3), np.zeros(3)) if link.parent < 0 else
                                     (turned[link.parent], origins[link.parent], self.links[link.parent].point))  # fmt: skip
            axes.append(before @ link.axis)
            origins.append(origin + before @ (link.point - point) + (axes[-1] * x if link.slides else 0.0))
            turned.append(before if link.slides else before @ _rotation(link.axis, x))
        return turned, origins, axes

    def path(self, name: str) -> list[int]:
        """The links from the ground to that of the name."""
        found, k = [], self.place[name]
        while k >= 0:
            found.append(k)
            k = self.links[k].parent
        return found[::-1]

    def wheel(self, end: str, q: np.ndarray, w: np.ndarray, frames: Any) -> SimpleNamespace:
        """The contact of a wheel: path, lowest point, heading and right (3,), slip and camber angle [rad]."""
        turned, origins, axes = frames
        spin = self.place[f"{end}_spin"]
        path = self.path(f"{end}_spin")[:-1]
        axle = turned[path[-1]] @ RIGHT
        towards = DOWN - (DOWN @ axle) * axle
        point = origins[spin] + getattr(self.p, f"{end}_wheel_radius") * towards / np.linalg.norm(towards)
        ahead = np.cross(axle, DOWN)
        ahead /= np.linalg.norm(ahead)
        right = np.cross(DOWN, ahead)
        velocity = sum(w[k] * (axes[k] if self.links[k].slides else np.cross(axes[k], point - origins[k])) for k in path)
        return SimpleNamespace(path=path, point=point, ahead=ahead, right=right, slip=-(velocity @ right) / (velocity @ ahead),
                               camber=np.arcsin(axle @ DOWN))  # fmt: skip

    # Forces -----------------------------------------------------------------------------------------

    def forces(self, mbs: Any, t: float, item: int, q: Any, w: Any) -> np.ndarray:
        """The generalised forces (n,) apart from weight and inertia."""
        q, w = np.asarray(q), np.asarray(w)
        frames = self.frames(q)
        total = np.zeros(len(q))
        total[self.place["steer"]] -= self.p.steering_damping * w[self.place["steer"]]
        for name in FLEXIBLE:
            k = self.place[name]
            total[k] -= self.component.values[f"{name}_stiffness"] * q[k] + self.component.values[f"{name}_damping"] * w[k]
        drag, lift = self.p.drag * self.speed**2, self.p.lift * self.speed**2
        frame = self.path("roll")
        turned, origins, axes = frames
        reference = origins[frame[-1]] - turned[frame[-1]] @ DOWN * self.p.reference_height
        moving_ahead = turned[self.place["yaw"]][:, 0]
        total += self.on(frame, frames, reference, -drag * moving_ahead - lift * DOWN)
        slips = np.asarray(self.mbs.GetNodeOutput(self.slip_node, self.kind.Coordinates))
        for end, slip in zip(("front", "rear"), slips, strict=True):
            at, v = self.wheel(end, q, w, frames), {n: self.at_speed[f"{end}_{n}"] for n in TYRE_VALUES}
            side = v["cornering_stiffness"] * slip + v["camber_stiffness"] * at.camber
            drive = drag if end == "rear" else 0.0
            radius = getattr(self.p, f"{end}_section_radius")
            moment = (-v["aligning_stiffness"] * slip + v["camber_moment_stiffness"] * at.camber - radius * at.camber * drive) * DOWN
            moment = moment - radius * v["load"] * at.camber * at.ahead
            total += self.on(at.path, frames, at.point, side * at.right - v["load"] * DOWN + drive * at.ahead, moment)
        if self.device is not None:
            handlebar, on_frame = self.device.torques(t, self.handlebar(q, w))
            steer = self.path("steer")
            total += self.on(steer, frames, origins[steer[-1]], np.zeros(3), handlebar * axes[steer[-1]])
            total += self.on(frame, frames, origins[frame[-1]], np.zeros(3), on_frame * axes[steer[-1]])
        return total

    def on(self, path: Sequence[int], frames: Any, point: np.ndarray, force: np.ndarray, moment: Any = 0.0) -> np.ndarray:
        """The generalised forces (n,) of a force at a point of the last link of a path, and of a moment on it."""
        _, origins, axes = frames
        total = np.zeros(len(self.links))
        for k in path:
            total[k] = axes[k] @ force if self.links[k].slides else axes[k] @ (np.cross(point - origins[k], force) + moment)
        return total

    def slip_rates(self, mbs: Any, t: float, item: int, slips: Any) -> np.ndarray:
        """The rates of the relaxed slip angles (2,) [rad/s]."""
        q, w = self.coordinates()
        frames = self.frames(q)
        return np.array([(self.wheel(end, q, w, frames).slip - slip) * self.speed / self.at_speed[f"{end}_relaxation_length"]
                         for end, slip in zip(("front", "rear"), slips, strict=True)])  # fmt: skip

    def handlebar(self, q: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Steer angle, steer rate and frame rate (3,)."""
        _, _, axes = self.frames(q)
        frame, steer = self.path("roll"), self.place["steer"]
        rate = sum(w[k] * axes[k] for k in frame if not self.links[k].slides)
        return np.array([q[steer], w[steer], rate @ axes[steer]])


TYRE_VALUES = ("cornering_stiffness", "camber_stiffness", "aligning_stiffness", "camber_moment_stiffness", "load")


class _Values(dict):
    """Values by key and by attribute."""

    __getattr__ = dict.__getitem__


def _is_rate(name: str) -> bool:
    return name.endswith(("_rate", "_velocity"))


def _coordinate(name: str) -> str:
    """The coordinate of the tree that a state is, or is the rate of."""
    for ending in ("_rate", "_velocity", "_angle", "_position"):
        name = name.removesuffix(ending)
    return name


def _links(freedoms: Sequence[Any], body: Sequence[Any]) -> list[Link]:
    """Along, then every freedom after the one before it in a path, then the spinning wheels."""
    links = [Link("along", -1, np.zeros(3), np.array([1.0, 0.0, 0.0]), True)]
    place: dict[int, int] = {}
    for part in body:
        for k, j in enumerate(part.path):
            if id(j) in place:
                continue
            parent = place[id(part.path[k - 1])] if k else 0
            axis = RIGHT if j.axis is None else np.array([j.axis[0], 0.0, j.axis[1]], float)
            place[id(j)] = len(links)
            links.append(Link(_coordinate(j.rate), parent, np.array([j.point[0], 0.0, j.point[1]], float), axis, j.axis is None))
    for wheel, part in (("front", body[-2]), ("rear", body[-1])):
        centre = np.array([part.centre[0], 0.0, part.centre[1]], float)
        links.append(Link(f"{wheel}_spin", place[id(part.path[-1])], centre, -RIGHT))
    return links


def _tree(exu: Any, links: Sequence[Link], body: Sequence[Any], p: Any) -> dict[str, Any]:
    """The arguments of ObjectKinematicTree. The axis of a link is the third one of its own axes."""
    own = [_own_axes(link.axis) for link in links]
    place = {link.name: k for k, link in enumerate(links)}
    mass, moment, second = np.zeros(len(links)), np.zeros((len(links), 3)), np.zeros((len(links), 3, 3))
    for k, part in enumerate(body):
        wheel = {len(body) - 2: "front", len(body) - 1: "rear"}.get(k)
        link = place[f"{wheel}_spin" if wheel else _coordinate(part.path[-1].rate)]
        pitch = getattr(p, f"{wheel}_spin_inertia") if wheel else part.roll_inertia + part.yaw_inertia  # plays no part
        tensor = np.array([[part.roll_inertia, 0, -part.product], [0, pitch, 0], [-part.product, 0, part.yaw_inertia]], float)
        centre = np.array([part.centre[0], 0.0, part.centre[1]], float) - links[link].point
        mass[link] += part.mass
        moment[link] += part.mass * centre
        second[link] += tensor + part.mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    centres = moment / np.maximum(mass, 1e-300)[:, None]
    central = [about - m * (c @ c * np.eye(3) - np.outer(c, c)) for about, m, c in zip(second, mass, centres, strict=True)]
    before = [np.eye(3) if link.parent < 0 else own[link.parent] for link in links]
    points = [np.zeros(3) if link.parent < 0 else links[link.parent].point for link in links]
    return {
        "jointTypes": [exu.JointType.PrismaticZ if link.slides else exu.JointType.RevoluteZ for link in links],
        "linkParents": [link.parent for link in links],
        "jointTransformations": exu.Matrix3DList([b.T @ o for b, o in zip(before, own, strict=True)]),
        "jointOffsets": exu.Vector3DList([b.T @ (link.point - x) for b, link, x in zip(before, links, points, strict=True)]),
        "linkInertiasCOM": exu.Matrix3DList([o.T @ each @ o for o, each in zip(own, central, strict=True)]),
        "linkCOMs": exu.Vector3DList([o.T @ c for o, c in zip(own, centres, strict=True)]),
        "linkMasses": list(mass),
    }


def _own_axes(axis: np.ndarray) -> np.ndarray:
    """A rotation matrix (3, 3) whose third column is the axis."""
    first = np.cross(axis, [0.3, 0.5, 0.8])
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(axis, first), axis])


def _rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """The rotation (3, 3) about a unit axis (Rodrigues)."""
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


if __name__ == "__main__":
    main(run)
