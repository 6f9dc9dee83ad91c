"""Exudyn: the touring motorcycle of 2020 as rigid bodies in space, alone and with the FMU of a rider at its handlebar.

The bodies are links of a kinematic tree (ObjectKinematicTree): along, to the side, yaw, roll, then each flexible
freedom and the steer, and the spinning wheels. Exudyn forms inertia and gyroscopic forces in full motion. The forces
are given here in full motion too: springs, loads at the lowest points of the wheels, drag and drive, and the tyres,
whose relaxed slip angles are states of a first-order object (ObjectGenericODE1). Nothing is linearised: states are so
small that their squares do not show. From the motion out of every state alone over INTERVAL follows the transition
matrix, and from it every eigenvalue; they are compared with those of `vehicle_fmu`.

Axes are x forward, y right, z down. The FMU steps in the pre-step function and is asked in the force function (see
`motofmi.scenarios.hosts.device`).
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.linalg import expm

from fmus import Component, linearise
from fmus.export.build import build
from fmus.expressions.functions import NUMERIC
from motofmi.scenarios.hosts.device import Device
from motofmi.scenarios.hosts.exudyn_tree import DOWN, RIGHT, Tree, coordinate, is_rate
from motofmi.scenarios.hosts.table import main
from rider_fmu import riders
from vehicle_fmu import motorcycles, ridden
from vehicle_fmu.components.touring_motorcycle import FLEXIBLE, bodies

HOST, PACKAGE = "Exudyn", "exudyn"
SMALL = 1e-5  # of the unit of each state; what is not linear is this squared
INTERVAL = 0.004  # s, below half the period of the fastest mode
TYRES = ("front_relaxed_slip", "rear_relaxed_slip")


def run(speed: float = 30.0, step: float = 5e-4, duration: float = 1.0, rider: str = "mean_2011") -> dict[str, float]:
    """The largest error of an eigenvalue of the motorcycle, and of its motion with the rider's FMU after a push, as
    shares.

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
    own = [held.states.index(name) for name in ("roll_angle", "steer_angle")]
    errors = np.abs(found[:, own] - exact[:, columns]).max(axis=0) / np.abs(exact[:, columns]).max(axis=0)
    return {"largest_eigenvalue_error": max(float(np.abs(theirs - z).min() / abs(z)) for z in ours),
            "roll_error_with_rider": float(errors[0]), "steer_error_with_rider": float(errors[1])}  # fmt: skip


def eigenvalues(motorcycle: Component, speed: float, step: float = 5e-4) -> np.ndarray:
    """The eigenvalues (n,) [1/s] of the multibody motorcycle in straight running at a speed [m/s]."""
    columns = [motion(motorcycle, speed, step, INTERVAL, {name: SMALL})[-1] / SMALL for name in motorcycle.states]
    return np.log(np.linalg.eigvals(np.column_stack(columns)).astype(complex)) / INTERVAL


def exact_motion(space: Any, start: dict[str, float], step: float, count: int) -> np.ndarray:
    """States (count, n) of a linear system from initial values by name."""


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


class MultibodyMotorcycle:
    """The motorcycle in an Exudyn system, running straight ahead."""

    def __init__(self, exu: Any, mbs: Any, motorcycle: Component, speed: float, start: dict[str, float], device: Device | None):
        self.mbs, self.speed, self.device, self.component = mbs, speed, device, motorcycle
        self.at_speed = motorcycle.run({**motorcycle.start_values(), "speed": speed}, NUMERIC)
        self.p = SimpleNamespace(**motorcycle.values)
        body, _ = bodies(_Values({**motorcycle.values, "speed": speed}), NUMERIC)
        self.tree = Tree(body, self.p.front_spin_inertia, self.p.rear_spin_inertia)
        self.place = self.tree.place
        zero = np.zeros(len(self.place))
        position, rate = zero.copy(), zero.copy()
        rate[self.place["along"]] = speed
        for wheel, radius in (("front", self.p.front_wheel_radius), ("rear", self.p.rear_wheel_radius)):
            rate[self.place[f"{wheel}_spin"]] = speed / radius
        for name, value in start.items():
            if name not in TYRES:
                (rate if is_rate(name) else position)[self.place[coordinate(name)]] = value
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
        forces: Any = self.forces  # Exudyn's hints name classes of its own for functions
        slip_rates: Any = self.slip_rates
        mbs.AddObject(ObjectKinematicTree(nodeNumber=node, gravity=[0.0, 0.0, self.p.gravity], forceUserFunction=forces,
                                          **self.tree.arguments(exu)))  # fmt: skip
        mbs.AddObject(ObjectGenericODE1(nodeNumbers=[self.slip_node], rhsUserFunction=slip_rates))

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
        return np.array([own[name] if name in own else (w if is_rate(name) else q)[self.place[coordinate(name)]]
                         for name in self.component.states])  # fmt: skip

    # Kinematics -------------------------------------------------------------------------------------

    def wheel(self, end: str, q: np.ndarray, w: np.ndarray, frames: Any) -> SimpleNamespace:
        """The contact of a wheel: path, lowest point, heading and right (3,), slip and camber angle [rad]."""
        turned, joints, axes = frames
        spin = self.place[f"{end}_spin"]
        path = self.tree.path(f"{end}_spin")[:-1]
        axle = turned[path[-1]] @ RIGHT
        towards = DOWN - (DOWN @ axle) * axle
        height = -self.tree.links[spin].point[2]  # 2e-5 m above the printed radius of the front wheel
        point = joints[spin] + height * towards / np.linalg.norm(towards)
        ahead = np.cross(axle, DOWN)
        ahead /= np.linalg.norm(ahead)
        right = np.cross(DOWN, ahead)
        velocity = sum(w[k] * (axes[k] if self.tree.links[k].slides else np.cross(axes[k], point - joints[k])) for k in path)
        return SimpleNamespace(path=path, point=point, ahead=ahead, right=right, slip=-(velocity @ right) / (velocity @ ahead),
                               camber=np.arcsin(axle @ DOWN))  # fmt: skip

    # Forces -----------------------------------------------------------------------------------------

    def forces(self, mbs: Any, t: float, item: int, q: Any, w: Any) -> np.ndarray:
        """The generalised forces (n,) apart from weight and inertia."""
        q, w = np.asarray(q), np.asarray(w)
        frames = self.tree.frames(q)
        total = np.zeros(len(q))
        total[self.place["steer"]] -= self.p.steering_damping * w[self.place["steer"]]
        for name in FLEXIBLE:
            k = self.place[name]
            total[k] -= self.component.values[f"{name}_stiffness"] * q[k] + self.component.values[f"{name}_damping"] * w[k]
        drag, lift = self.p.drag * self.speed**2, self.p.lift * self.speed**2
        frame = self.tree.path("roll")
        turned, joints, axes = frames
        reference = joints[frame[-1]] - turned[frame[-1]] @ DOWN * self.p.reference_height
        moving_ahead = turned[self.place["yaw"]][:, 0]
        total += self.tree.force(frame, frames, reference, -drag * moving_ahead - lift * DOWN)
        slips = np.asarray(self.mbs.GetNodeOutput(self.slip_node, self.kind.Coordinates))
        for end, slip in zip(("front", "rear"), slips, strict=True):
            at, v = self.wheel(end, q, w, frames), {n: self.at_speed[f"{end}_{n}"] for n in TYRE_VALUES}
            side = v["cornering_stiffness"] * slip + v["camber_stiffness"] * at.camber
            drive = drag if end == "rear" else 0.0
            radius = getattr(self.p, f"{end}_section_radius")
            moment = (-v["aligning_stiffness"] * slip + v["camber_moment_stiffness"] * at.camber - radius * at.camber * drive) * DOWN
            moment = moment - radius * v["load"] * at.camber * at.ahead
            total += self.tree.force(at.path, frames, at.point, side * at.right - v["load"] * DOWN + drive * at.ahead, moment)
        if self.device is not None:
            handlebar, on_frame = self.device.torques(t, self.handlebar(q, w))
            steer = self.tree.path("steer")
            total += self.tree.force(steer, frames, joints[steer[-1]], np.zeros(3), handlebar * axes[steer[-1]])
            total += self.tree.force(frame, frames, joints[frame[-1]], np.zeros(3), on_frame * axes[steer[-1]])
        return total

    def slip_rates(self, mbs: Any, t: float, item: int, slips: Any) -> np.ndarray:
        """The rates of the relaxed slip angles (2,) [rad/s]."""
        q, w = self.coordinates()
        frames = self.tree.frames(q)
        return np.array([(self.wheel(end, q, w, frames).slip - slip) * self.speed / self.at_speed[f"{end}_relaxation_length"]
                         for end, slip in zip(("front", "rear"), slips, strict=True)])  # fmt: skip

    def handlebar(self, q: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Steer angle, steer rate and frame rate (3,)."""
        _, _, axes = self.tree.frames(q)
        frame, steer = self.tree.path("roll"), self.place["steer"]
        rate = sum(w[k] * axes[k] for k in frame if not self.tree.links[k].slides)
        return np.array([q[steer], w[steer], rate @ axes[steer]])


TYRE_VALUES = ("cornering_stiffness", "camber_stiffness", "aligning_stiffness", "camber_moment_stiffness", "load")


class _Values(dict):
    """Values by key and by attribute."""

    __getattr__ = dict.__getitem__


if __name__ == "__main__":
    main(run)
