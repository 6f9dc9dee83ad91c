"""Exudyn: the touring motorcycle of 2020 in a corner, its accelerations and eigenvalues found a second time.

The bodies are links of a kinematic tree (ObjectKinematicTree) that moves in space. Exudyn forms inertia, gyroscopic
and centrifugal forces in full motion; the other forces are given here. One explicit Euler step of one second gives
the accelerations without an error of integration: the change of every rate. Loads and longitudinal forces of the
tyres are those for which the wheels neither leave the road nor slide along their heading: with the rows G of these
conditions, formed here, G w' + G' w = 0, where G' w follows from central differences along the motion. At an
equilibrium of `vehicle_fmu.large_motion` all rates must be 0, and their slopes must have the same eigenvalues.

Tyre forces are those of `vehicle_fmu.large_motion.magic_formula`, which the tests compare with a second implementation.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np

from fmus import Component
from fmus.expressions.functions import NUMERIC
from motofmi.scenarios.hosts.exudyn_tree import DOWN, RIGHT, Tree, coordinate
from motofmi.scenarios.hosts.table import main
from vehicle_fmu import motorcycles
from vehicle_fmu.components.touring_motorcycle import FLEXIBLE, bodies
from vehicle_fmu.large_motion.equations import LargeMotion
from vehicle_fmu.large_motion.steady_turning import SteadyTurning
from vehicle_fmu.large_motion.touring_tree import ENDS, ORDER, tyre

HOST, PACKAGE = "Exudyn", "exudyn"
CHANGE = 1e-6  # of a state, for slopes by central differences
AHEAD_BY = 1e-5  # s, for G' w
ITERATIONS = 8
DEPENDENT = ("vertical", "pitch", "front_spin", "rear_spin")


def run(speed: float = 30.0, lean: float = 30.0) -> dict[str, float]:
    """The largest rate left at the equilibrium, and the largest error of an eigenvalue as a share, at a speed [m/s]
    and lean [deg].

    Raises ModuleNotFoundError without Exudyn.
    """
    left, errors = compared(motorcycles.load("tum_2020"), speed, lean)
    return {"largest_rate_at_equilibrium": left, "largest_eigenvalue_error": float(errors.max())}


def compared(motorcycle: Component, speed: float, lean: float) -> tuple[float, np.ndarray]:
    """The largest rate [m/s2, rad/s2, rad/s] at the equilibrium of `SteadyTurning`, and the error (n,) of every
    eigenvalue as a share.
    """
    turning = SteadyTurning(LargeMotion(motorcycle), speed)
    ours = turning.at(np.radians(lean))
    host = MultibodyCorner(motorcycle, turning.motion.states, ours.u, ours.multipliers)
    theirs, own = np.linalg.eigvals(host.matrix(ours.x)), np.linalg.eigvals(turning.linearised(ours)[0])
    return float(np.abs(host.rates(ours.x)).max()), np.abs(theirs[:, None] - own).min(axis=0) / np.abs(own)


class MultibodyCorner:
    """The motorcycle in an Exudyn system with the torques (drive, steering, ...) and about the loads (4,) of an
    equilibrium.
    """

    def __init__(self, motorcycle: Component, states: tuple[str, ...], torques: np.ndarray, loads: np.ndarray):
        import exudyn as exu  # noqa: PLC0415 - an optional package
        from exudyn.itemInterface import NodeGenericODE2, ObjectKinematicTree  # noqa: PLC0415

        self.p, self.torques, self.loads = SimpleNamespace(**motorcycle.values), torques, loads.copy()
        self.tyres, self.slips = {end: tyre(motorcycle, end) for end in ENDS}, np.zeros(2)
        body, _ = bodies(_Values({**motorcycle.values, "speed": 0.0}), NUMERIC)
        self.tree = Tree(
            body,
            self.p.front_spin_inertia,
            self.p.rear_spin_inertia,
            [motorcycle.supplement.get(f"{name}_yy", 0.0) for name in ORDER],
        )
        self.place, count = self.tree.place, len(self.tree.links)
        names = {"forward_speed": "along", "lateral_velocity": "lateral"}
        self.rate_of = [
            self.place[names.get(n, coordinate(n))] for n in states if n.endswith(("_rate", "_velocity", "_speed"))
        ]
        self.angle_of = [self.place[coordinate(n)] for n in states if n.endswith(("_angle", "_position"))]
        self.dependent = [self.place[n] for n in DEPENDENT]
        self.exu, self.mbs, zero = exu, exu.SystemContainer().AddSystem(), np.zeros(count)
        node = self.mbs.AddNode(
            NodeGenericODE2(
                referenceCoordinates=zero,
                initialCoordinates=zero,
                initialCoordinates_t=zero,
                numberOfODE2Coordinates=count,
            )
        )
        self.mbs.AddObject(
            ObjectKinematicTree(
                nodeNumber=node,
                gravity=[0.0, 0.0, self.p.gravity],
                forceUserFunction=self.forces,
                **self.tree.arguments(exu),
            )
        )
        self.mbs.Assemble()
        self.settings = exu.SimulationSettings()
        self.settings.timeIntegration.numberOfSteps, self.settings.timeIntegration.endTime = 1, 1.0
        self.settings.timeIntegration.verboseMode = 0
        self.settings.solution.file.write = False
        self.per_load: np.ndarray | None = None

    # Rates ------------------------------------------------------------------------------------------

    def matrix(self, x: np.ndarray) -> np.ndarray:
        """The slopes (nx, nx) of the rates at states (nx,)."""
        steps = CHANGE * np.eye(len(x))
        return np.transpose([(self.rates(x + step) - self.rates(x - step)) / (2 * CHANGE) for step in steps])

    def rates(self, x: np.ndarray) -> np.ndarray:
        """The rates of states (nx,) of `LargeMotion`."""
        q, w = np.zeros(len(self.place)), np.zeros(len(self.place))
        q[self.angle_of], w[self.rate_of], self.slips = x[len(self.rate_of) : -2], x[: len(self.rate_of)], x[-2:]
        for _ in range(ITERATIONS):
            rows, depth = self.conditions(q)
            q[self.dependent[:2]] += np.linalg.solve(rows[:2, self.dependent[:2]], depth)
        rows, _ = self.conditions(q)
        w[self.dependent] = -np.linalg.solve(rows[:, self.dependent], rows @ w)
        before, after = (self.conditions(q + sign * AHEAD_BY * w)[0] for sign in (-1, 1))
        change = (after - before) @ w / (2 * AHEAD_BY)
        acceleration = self._accelerations(q, w, rows, change)
        along, lateral, yaw = (self.place[n] for n in ("along", "lateral", "yaw"))
        acceleration[along] += w[lateral] * w[yaw]
        acceleration[lateral] -= w[along] * w[yaw]
        at = [self.wheel(end, q, w) for end in ENDS]
        lengths = [self.tyres[end].relaxation_length(self.loads[k], w[along]) for k, end in enumerate(ENDS)]
        lag = [
            (wheel.slip - slip) * wheel.along / length
            for wheel, slip, length in zip(at, self.slips, lengths, strict=True)
        ]
        return np.concatenate([acceleration[self.rate_of], w[self.angle_of], lag])

    def _accelerations(self, q: np.ndarray, w: np.ndarray, rows: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Accelerations (n,) with the loads for which the wheels stay on the road and roll."""

        def left() -> np.ndarray:
            return rows @ self.exudyn_accelerations(q, w) + change

        if self.per_load is None:  # about the equilibrium, good enough for Newton's method near it
            start, columns = left(), []
            for k in range(4):
                self.loads[k] += 1.0
                columns.append(left() - start)
                self.loads[k] -= 1.0
            self.per_load = np.transpose(columns)
        for _ in range(ITERATIONS):
            self.loads = self.loads - np.linalg.solve(self.per_load, left())
        return self.exudyn_accelerations(q, w)

    def exudyn_accelerations(self, q: np.ndarray, w: np.ndarray) -> np.ndarray:
        """The accelerations (n,) by Exudyn, in fixed axes."""
        data, initial = self.mbs.systemData, self.exu.ConfigurationType.Initial
        data.SetODE2Coordinates(q, initial)
        data.SetODE2Coordinates_t(w, initial)
        self.mbs.SolveDynamic(self.settings, solverType=self.exu.DynamicSolverType.ExplicitEuler)
        return np.asarray(data.GetODE2Coordinates_t()) - w

    # Forces -----------------------------------------------------------------------------------------

    def conditions(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The rows (4, n) of rising and sliding velocity of both wheels, and their depth in the road (2,) [m]."""
        wheels = [self.wheel(end, q, np.zeros_like(q)) for end in ENDS]
        return np.array([*(wheel.rises for wheel in wheels), *(wheel.slides for wheel in wheels)]), np.array(
            [w.depth for w in wheels]
        )

    def wheel(self, end: str, q: np.ndarray, w: np.ndarray) -> SimpleNamespace:
        """The contact of a wheel: path of its carrier, point, heading and right (3,), slip and camber, rows and depth
        of `conditions`.
        """
        frames = self.tree.frames(q)
        turned, joints, axes = frames
        spin, tube = self.place[f"{end}_spin"], self.tyres[end].section_radius
        path = self.tree.path(f"{end}_spin")[:-1]
        axle = turned[path[-1]] @ RIGHT
        towards = DOWN - (DOWN @ axle) * axle
        level = np.linalg.norm(towards)
        point = joints[spin] + (-self.tree.links[spin].point[2] - tube) * towards / level + tube * DOWN
        ahead = np.cross(axle, DOWN) / level
        right = np.cross(DOWN, ahead)
        slides = self.tree.force(path, frames, point, ahead)
        slides[spin] -= getattr(self.p, f"{end}_wheel_radius") - tube + tube * level
        velocity = sum(
            w[k] * (axes[k] if self.tree.links[k].slides else np.cross(axes[k], point - joints[k])) for k in path
        )
        return SimpleNamespace(
            path=path,
            point=point,
            ahead=ahead,
            right=right,
            frames=frames,
            camber=np.arcsin(axle @ DOWN),
            slip=-np.arctan2(velocity @ right, velocity @ ahead),
            along=velocity @ ahead,
            depth=point @ DOWN,
            rises=self.tree.force(path, frames, point, -DOWN),
            slides=slides,
        )

    def forces(self, mbs: Any, t: float, item: int, q: Any, w: Any) -> np.ndarray:
        """The generalised forces (n,) apart from weight and inertia."""
        q, w, place = np.asarray(q), np.asarray(w), self.place
        frames = self.tree.frames(q)
        turned, joints, _ = frames
        total = np.zeros(len(q))
        total[place["steer"]] = self.torques[1] - self.p.steering_damping * w[place["steer"]]
        for name in FLEXIBLE:
            k = place[name]
            total[k] = -getattr(self.p, f"{name}_stiffness") * q[k] - getattr(self.p, f"{name}_damping") * w[k]
        frame, squared = self.tree.path("pitch"), w[place["along"]] ** 2
        reference = joints[frame[-1]] - turned[frame[-1]] @ DOWN * self.p.reference_height
        wind = np.array([-self.p.drag, 0.0, -self.p.lift]) * squared
        total += self.tree.force(frame, frames, reference, wind, self.p.pitching_moment * squared * RIGHT)
        total[place["rear_spin"]] += self.torques[0]
        for k, end in enumerate(ENDS):
            at = self.wheel(end, q, w)
            side, moment = self.tyres[end].forces(self.loads[k], self.slips[k], at.camber)
            total += self.tree.force(at.path, frames, at.point, side * at.right, moment * DOWN)
            total += self.loads[k] * at.rises + self.loads[k + 2] * at.slides
        return total


class _Values(dict):
    """Values by key and by attribute."""

    __getattr__ = dict.__getitem__


if __name__ == "__main__":
    main(run)
