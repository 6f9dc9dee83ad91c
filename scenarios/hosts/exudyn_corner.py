"""Exudyn: the touring motorcycle of 2020 in a corner, its accelerations and eigenvalues found a second time.

The bodies are links of a kinematic tree (ObjectKinematicTree) that moves in space. Exudyn forms inertia, gyroscopic
and centrifugal forces in full motion; the other forces are given here: suspensions with the rear linkage solved as two
circles and a rod, tyres that deflect and slip. One explicit Euler step of one second gives the accelerations without an
error of integration: the change of every rate. Rates of what is a state of `vehicle_fmu.large_motion` but no coordinate
of the tree, as the tyres' deflections and longitudinal slips, follow from central differences along the motion.

Without deflection and slip, loads and longitudinal forces are those for which the wheels neither leave the road nor
slide along their heading: with the rows G of these conditions, formed here, G w' + G' w = 0. At an equilibrium of
`vehicle_fmu.large_motion` all rates must be 0 but the forward speed's, and their slopes must have the same eigenvalues,
also with a rider at the handlebar port. Tyre forces are those of `vehicle_fmu.large_motion.magic_formula`, which the
tests compare with a second implementation.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fmus import Component, linearise
from fmus.interfaces.handlebar import MOTION, TORQUES
from motofmi.scenarios.hosts.exudyn_corner_forces import CornerForces
from motofmi.scenarios.hosts.exudyn_tree import coordinate
from motofmi.scenarios.hosts.table import main
from vehicle_fmu import motorcycles
from vehicle_fmu.large_motion.applied_forces import INPUTS
from vehicle_fmu.large_motion.corner_modes import corner_modes, held
from vehicle_fmu.large_motion.equations import LargeMotion
from vehicle_fmu.large_motion.steady_turning import SteadyTurning
from vehicle_fmu.large_motion.touring_tree import ENDS

HOST, PACKAGE = "Exudyn", "exudyn"
CHANGE = 1e-6  # of a state, for slopes by central differences
AHEAD_BY = 1e-5  # s, for rates along the motion
CHANGE_ALONG = 1e-5  # of a state where rates are differences along the motion, whose rounding is larger
ITERATIONS = 8
DEPENDENT = ("vertical", "pitch", "front_spin", "rear_spin")


def run(speed: float = 30.0, lean: float = 30.0, acceleration: float = 0.0) -> dict[str, float]:
    """The largest rate left at the equilibrium, and the largest error of an eigenvalue as a share, at a speed [m/s],
    a lean angle [deg] and a longitudinal acceleration [m/s2].

    Raises ModuleNotFoundError without Exudyn.
    """
    left, errors = compared(motorcycles.load("tum_2020"), speed, lean, acceleration)
    return {"largest_rate_at_equilibrium": left, "largest_eigenvalue_error": float(errors.max())}


def compared(
    motorcycle: Component, speed: float, lean: float, acceleration: float = 0.0, devices: Sequence[Component] = ()
) -> tuple[float, np.ndarray]:
    """The largest rate [m/s2, rad/s2, rad/s] left at the equilibrium of `SteadyTurning`, and the error (n,) of every
    eigenvalue as a share, with devices at the handlebar port. With an acceleration the forward speed is held.
    """
    vehicle = held(motorcycle, devices)
    turning = SteadyTurning(LargeMotion(vehicle), speed)
    ours = turning.at(np.radians(lean), acceleration)
    point = np.radians([lean]), np.array([acceleration])
    own = corner_modes(turning, motorcycle, devices, *point).eigenvalues[0]
    host = MultibodyCorner(vehicle, turning.motion.states, ours.u, ours.multipliers)
    first = int(acceleration != 0)
    theirs = np.linalg.eigvals(host.with_devices(ours.x, devices)[first:, first:])
    left = host.rates(ours.x)
    left[0] -= acceleration
    return float(np.abs(left).max()), np.abs(theirs[:, None] - own).min(axis=0) / np.abs(own)


class MultibodyCorner:
    """The motorcycle in an Exudyn system with the inputs u (nu,) and about the loads and longitudinal forces (4,) of an
    equilibrium.

    Raises ValueError where some but not all of deflections and longitudinal slips are free.
    """

    def __init__(self, motorcycle: Component, states: tuple[str, ...], u: np.ndarray, loads: np.ndarray):
        import exudyn as exu  # noqa: PLC0415 - an optional package
        from exudyn.itemInterface import NodeGenericODE2, ObjectKinematicTree  # noqa: PLC0415

        self.applied = CornerForces(motorcycle, u, loads)
        self.states, self.place = states, self.applied.place
        free = [n for n in states if n.endswith(("_tyre_deflection_position", "_longitudinal_slip"))]
        self.free = len(free) == 4
        if len(free) not in (0, 4):
            raise ValueError("deflections and longitudinal slips must all be free or all be locked")
        self.applied.free = self.free
        names = {"forward_speed": "along", "lateral_velocity": "lateral"}
        self.rate_of = {
            k: self.place[names.get(n, coordinate(n))]
            for k, n in enumerate(states)
            if n.endswith(("_rate", "_velocity", "_speed")) and "tyre" not in n
        }
        self.angle_of = {
            k: self.place[coordinate(n)]
            for k, n in enumerate(states)
            if n.endswith(("_angle", "_position")) and "tyre" not in n
        }
        self.measured = [k for k, n in enumerate(states) if "tyre_deflection" in n or n.endswith("_longitudinal_slip")]
        self.dependent = [self.place[n] for n in DEPENDENT]
        self.exu, self.mbs, count = exu, exu.SystemContainer().AddSystem(), len(self.place)
        zero = np.zeros(count)
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
                gravity=[0.0, 0.0, self.applied.p.gravity],
                forceUserFunction=lambda mbs, t, item, q, w: self.applied(np.asarray(q), np.asarray(w)),
                **self.applied.tree.arguments(exu),
            )
        )
        self.mbs.Assemble()
        self.settings = exu.SimulationSettings()
        self.settings.timeIntegration.numberOfSteps, self.settings.timeIntegration.endTime = 1, 1.0
        self.settings.timeIntegration.verboseMode = 0
        self.settings.solution.file.write = False
        self.per_load: np.ndarray | None = None

    # Slopes -----------------------------------------------------------------------------------------

    def with_devices(self, x: np.ndarray, devices: Sequence[Component]) -> np.ndarray:
        """The slopes (n, n) of the rates of states (nx,) and of linear devices at the handlebar port."""
        total = self.matrix(x)
        own = len(total)
        motion = self._slopes(x, self.port_motion)
        by_torque = np.zeros((own, len(TORQUES)))
        for k, name in enumerate(TORQUES):
            place = INPUTS.index(name)
            ends = []
            for side in (1, -1):
                self.applied.u[place] += side
                ends.append(self.rates(x))
                self.applied.u[place] -= side
            by_torque[:, k] = (ends[0] - ends[1]) / 2
        for part in (linearise(device) for device in devices):
            reads = motion[[list(MOTION).index(name) for name in part.inputs]]
            gives = [part.outputs.index(name) for name in TORQUES]
            before = len(total)
            grown = np.zeros((before + len(part.A), before + len(part.A)))
            grown[:before, :before] = total
            grown[:own, :own] += by_torque @ part.D[gives] @ reads
            grown[:own, before:], grown[before:, :own] = by_torque @ part.C[gives], part.B @ reads
            grown[before:, before:] = part.A
            total = grown
        return total

    def matrix(self, x: np.ndarray) -> np.ndarray:
        """The slopes (nx, nx) of the rates at states (nx,)."""
        return self._slopes(x, self.rates)

    def _slopes(self, x: np.ndarray, function: Any) -> np.ndarray:
        change = CHANGE_ALONG if self.free else CHANGE
        steps = change * np.eye(len(x))
        return np.transpose([(function(x + step) - function(x - step)) / (2 * change) for step in steps])

    def port_motion(self, x: np.ndarray) -> np.ndarray:
        """Steer angle, steer rate, and the frame's rate about the steer axis (3,) at states (nx,)."""
        q, w = self._placed(x)
        return np.array([q[self.place["steer"]], w[self.place["steer"]], self.applied.frame_rate(q, w)])

    # Rates ------------------------------------------------------------------------------------------

    def rates(self, x: np.ndarray) -> np.ndarray:
        """The rates of states (nx,) of `LargeMotion`."""
        q, w = self._placed(x)
        if self.free:
            acceleration = self.exudyn_accelerations(q, w)
        else:
            rows, _ = self.applied.conditions(q)
            before, after = (self.applied.conditions(q + sign * AHEAD_BY * w)[0] for sign in (-1, 1))
            acceleration = self._accelerations(q, w, rows, (after - before) @ w / (2 * AHEAD_BY))
        found = np.zeros(len(x))
        if self.free:
            before, after = (
                self._measures(q + sign * AHEAD_BY * w, w + sign * AHEAD_BY * acceleration) for sign in (-1, 1)
            )
            found[self.measured] = (after - before) / (2 * AHEAD_BY)
        along, lateral, yaw = (self.place[n] for n in ("along", "lateral", "yaw"))
        acceleration[along] += w[lateral] * w[yaw]
        acceleration[lateral] -= w[along] * w[yaw]
        for k, j in self.rate_of.items():
            found[k] = acceleration[j]
        for k, j in self.angle_of.items():
            found[k] = w[j]
        at = [self.applied.wheel(end, q, w) for end in ENDS]
        loads = [wheel.load for wheel in at] if self.free else self.applied.loads
        for k, (end, wheel) in enumerate(zip(ENDS, at, strict=True)):
            length = self.applied.tyres[end].relaxation_length(loads[k], w[along])
            found[len(x) - 2 + k] = (wheel.slip - x[len(x) - 2 + k]) * wheel.along / length
        return found

    def _placed(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates (n,) with the wanted deflections, their rates and longitudinal slips."""
        q, w = np.zeros(len(self.place)), np.zeros(len(self.place))
        for k, j in self.angle_of.items():
            q[j] = x[k]
        for k, j in self.rate_of.items():
            w[j] = x[k]
        self.applied.slips = x[-2:]

        def wanted(ending: str) -> np.ndarray:
            names = [f"{end}_{ending}" for end in ENDS]
            return np.array([x[self.states.index(n)] if n in self.states else 0.0 for n in names])

        for _ in range(ITERATIONS):
            rows, depth = self.applied.conditions(q)
            excess = depth - wanted("tyre_deflection_position")
            q[self.dependent[:2]] += np.linalg.solve(rows[:2, self.dependent[:2]], excess)
        rows, _ = self.applied.conditions(q, wanted("longitudinal_slip"))
        goal = np.concatenate([-wanted("tyre_deflection_rate"), np.zeros(2)])
        w[self.dependent] = np.linalg.solve(rows[:, self.dependent], goal - rows @ w)
        return q, w

    def _measures(self, q: np.ndarray, w: np.ndarray) -> np.ndarray:
        """The states at `measured`: deflection rates, deflections, longitudinal slips of both wheels."""
        at = [self.applied.wheel(end, q, w) for end in ENDS]
        return np.array([*(a.sinking for a in at), *(a.depth for a in at), *(a.ratio for a in at)])

    def _accelerations(self, q: np.ndarray, w: np.ndarray, rows: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Accelerations (n,) with the loads for which the wheels stay on the road and roll."""

        def left() -> np.ndarray:
            return rows @ self.exudyn_accelerations(q, w) + change

        if self.per_load is None:  # about the equilibrium, good enough for Newton's method near it
            start, columns = left(), []
            for k in range(4):
                self.applied.loads[k] += 1.0
                columns.append(left() - start)
                self.applied.loads[k] -= 1.0
            self.per_load = np.transpose(columns)
        for _ in range(ITERATIONS):
            self.applied.loads = self.applied.loads - np.linalg.solve(self.per_load, left())
        return self.exudyn_accelerations(q, w)

    def exudyn_accelerations(self, q: np.ndarray, w: np.ndarray) -> np.ndarray:
        """The accelerations (n,) by Exudyn, in fixed axes."""
        data, initial = self.mbs.systemData, self.exu.ConfigurationType.Initial
        data.SetODE2Coordinates(q.tolist(), initial)
        data.SetODE2Coordinates_t(w.tolist(), initial)
        self.mbs.SolveDynamic(self.settings, solverType=self.exu.DynamicSolverType.ExplicitEuler)
        return np.asarray(data.GetODE2Coordinates_t()) - w


if __name__ == "__main__":
    main(run)
