r"""The touring motorcycle in large motion on a flat road: rigid bodies, rolling toroidal wheels, Magic Formula tyres.

Coordinates: along, lateral and vertical position of the point A on the ground, yaw, lean (roll about the heading),
pitch about the axle direction through A, then the freedoms of `vehicle_fmu.components.touring_motorcycle` that are
free, and the wheels' spin. The equations do not depend on position and yaw, which are 0 here; u, v are the velocities
of A along and across the heading.

Both wheels stay on the road and roll without longitudinal slip (`vehicle_fmu.large_motion.contact`): four conditions
G w = 0, which give the vertical, pitch and spin motion. Their multipliers are the loads Z and the longitudinal forces
X_l of the tyres, on which side forces Y(Z, alpha', gamma) and moments depend:

    M (w' + e) + h = Q + G^T (Z, X_l),    G (w' + e) + g = 0,    e = (-v r, u r) of along and lateral
    slip angle     alpha = -atan(n.X' / t.X')
    relaxation     alpha'' = (alpha - alpha') t.X' / sigma(Z, u)        (alpha'' : rate of alpha')

Q: weights; side force along n at X and moment about D; drag D u^2 against the heading, lift L u^2 and moment M u^2 at
the reference point; springs and dampers; the torque of the drive between swingarm and rear wheel; the torques of the
handlebar port. Suspensions are rigid, and so are tyres under load: the published straight-running model keeps its
position at every speed.

Source: as in `vehicle_fmu.components.touring_motorcycle`; torus on a plane as in Lot, Meccanica 39 (2004) 481-496;
Lagrange's equations with multipliers in quasi-velocities as in Kane, Levinson (1985).
"""

from collections.abc import Collection
from types import SimpleNamespace

import numpy as np

from fmus.declaration.component import Component
from vehicle_fmu.large_motion.contact import DOWN, Contact, Wheel, contact, dot
from vehicle_fmu.large_motion.magic_formula import Tyre
from vehicle_fmu.large_motion.touring_tree import ENDS, SUSPENDED, touring_tree, tyre
from vehicle_fmu.large_motion.tree import Motion, Tree

AHEAD = np.array([1.0, 0.0, 0.0])
INPUTS = ("drive_torque", "steer_torque", "handlebar_torque", "frame_torque")
OUTPUTS = (
    "roll_angle",
    "roll_rate",
    "steer_angle",
    "steer_rate",
    "frame_rate",
    "yaw_rate",
    "lateral_velocity",
    "front_side_force",
    "rear_side_force",
    "front_load",
    "rear_load",
)
CONVERGED = 1e-10
ITERATIONS = 30


class LargeMotion:
    """x' = f(x, u) of a touring motorcycle, for stacked states (..., nx) and inputs (..., nu); order of `states` and
    INPUTS.
    """

    def __init__(self, motorcycle: Component):
        self.values = SimpleNamespace(**motorcycle.values)
        self.tree: Tree = touring_tree(motorcycle)
        self.tyres: dict[str, Tyre] = {end: tyre(motorcycle, end) for end in ENDS}
        self.place = self.tree.place
        self.free = [link.name for link in self.tree.links if link.name in SUSPENDED]
        moving = ["along", "lateral", "yaw", "roll", "steer", *self.free]
        self.moving = [self.place[name] for name in moving]
        self.dependent = [self.place[name] for name in ("vertical", "pitch", "front_spin", "rear_spin")]
        self.angles = [self.place[name] for name in ("roll", "steer", *self.free)]
        self.states = (
            "forward_speed",
            "lateral_velocity",
            "yaw_rate",
            "roll_rate",
            "steer_rate",
            *(f"{n}_rate" for n in self.free),
            "roll_angle",
            "steer_angle",
            *(f"{n}_position" for n in self.free),
            "front_relaxed_slip",
            "rear_relaxed_slip",
        )
        self.wheels = {end: self._wheel(end) for end in ENDS}

    def _wheel(self, end: str) -> Wheel:
        spin = self.place[f"{end}_spin"]
        height = -float(self.tree.links[spin].point[2])
        radius = self.values.__dict__[f"{end}_wheel_radius"]
        return Wheel(self.tree.parent[spin], spin, height, self.tyres[end].section_radius, radius)

    # Kinematics -------------------------------------------------------------------------------------

    def coordinates(self, x: np.ndarray, guess: np.ndarray | float = 0.0) -> np.ndarray:
        """The coordinates (..., n) at states (..., nx), with height and pitch, near a guess, that put both wheels on
        the ground.
        """
        q = np.zeros((*x.shape[:-1], len(self.tree.links)), x.dtype)
        q[..., self.angles] = x[..., len(self.moving) : -2]
        pair = self.dependent[:2]
        q[..., pair] = guess
        for _ in range(ITERATIONS):
            motion = self.tree.motion(q, np.zeros_like(q))
            wheels = self._contacts(motion).values()
            height = np.stack([wheel.point[..., 2] for wheel in wheels], axis=-1)
            slopes = np.stack([wheel.shift[..., 2, pair] for wheel in wheels], axis=-2)
            change = np.linalg.solve(slopes, height[..., None])[..., 0]
            q[..., pair] -= change
            if _small(change):
                break
        return q

    def _contacts(self, motion: Motion) -> dict[str, Contact]:
        return {end: contact(wheel, self.tree, motion) for end, wheel in self.wheels.items()}

    # Motion -----------------------------------------------------------------------------------------

    def posed(self, x: np.ndarray, u: np.ndarray, guess: np.ndarray | float = 0.0) -> SimpleNamespace:
        """What states (..., nx) and inputs (..., nu) say without accelerations: coordinates q, rates w, wheels, slip
        angles, the rows of the constraints, the mass matrix, and the generalised forces (..., n) `given`, of all but
        the tyres, less M e + h.
        """
        q = self.coordinates(x, guess)
        w = np.zeros_like(q)
        w[..., self.moving] = x[..., : len(self.moving)]
        still = self.tree.motion(q, np.zeros_like(q))
        rows = self._constraints(self._contacts(still).values())
        w[..., self.dependent] = -np.linalg.solve(rows[..., self.dependent], rows @ w[..., None])[..., 0]
        motion = self.tree.motion(q, w)
        wheels = self._contacts(motion)
        yaw, turning = w[..., self.place["yaw"]], np.zeros_like(w)
        turning[..., self.place["along"]] = -w[..., self.place["lateral"]] * yaw
        turning[..., self.place["lateral"]] = w[..., self.place["along"]] * yaw
        mass, bias, weight = self.tree.inertia_terms(motion)
        found = SimpleNamespace(
            q=q,
            w=w,
            motion=motion,
            wheels=wheels,
            rows=rows,
            turning=turning,
            mass=mass,
            weight=weight,
            relaxed=dict(zip(ENDS, np.moveaxis(x[..., -2:], -1, 0), strict=True)),
            slip={end: -np.arctan(wheel.across / wheel.along) for end, wheel in wheels.items()},
        )
        found.given = sum(self.forces(found, u).values()) - bias - (mass @ turning[..., None])[..., 0]
        return found

    def imbalance(
        self, x: np.ndarray, u: np.ndarray, multipliers: np.ndarray, guess: np.ndarray | float = 0.0
    ) -> np.ndarray:
        """The generalised forces (..., n) that are left where no rate changes, and what the slip angles lack of their
        relaxed values (..., 2), with loads and longitudinal forces (..., 4) given.
        """
        found = self.posed(x, u, guess)
        forces = self._tyre_forces(found, multipliers[..., :2])
        by_tyres = (self._unit_forces(found) @ forces[..., None])[..., 0] + (multipliers[..., None, :] @ found.rows)[
            ..., 0, :
        ]
        lag = [found.slip[end] - found.relaxed[end] for end in ENDS]
        return np.concatenate([found.given + by_tyres, np.stack(lag, axis=-1)], axis=-1)

    def at(self, x: np.ndarray, u: np.ndarray, guess: np.ndarray | float = 0.0) -> SimpleNamespace:
        """What `posed` finds, and accelerations w', loads, longitudinal and side forces, moments, and the `rates` of
        the states.
        """
        found = self.posed(x, u, guess)
        n = found.mass.shape[-1]
        left = np.zeros((*found.mass.shape[:-2], n + 4, n + 4), found.mass.dtype)
        left[..., :n, :n], left[..., :n, n:], left[..., n:, :n] = found.mass, -found.rows.swapaxes(-1, -2), found.rows
        right = np.zeros((*found.mass.shape[:-2], n + 4, 5), found.mass.dtype)
        right[..., :n, 0], right[..., :n, 1:] = found.given, self._unit_forces(found)
        bias = [getattr(wheel, name) for name in ("rise_bias", "roll_bias") for wheel in found.wheels.values()]
        right[..., n:, 0] = -np.stack(bias, axis=-1) - (found.rows @ found.turning[..., None])[..., 0]
        solved = np.linalg.solve(left, right)
        forces = self._consistent_forces(found, solved[..., n : n + 2, :])
        unknowns = solved[..., 0] + (solved[..., 1:] @ forces[..., None])[..., 0]
        found.acceleration = unknowns[..., :n]
        for name, values, k in (
            ("load", unknowns, n),
            ("longitudinal_force", unknowns, n + 2),
            ("side_force", forces, 0),
            ("yaw_moment", forces, 2),
        ):
            setattr(found, name, {end: values[..., k + i] for i, end in enumerate(ENDS)})
        slip_rates = [
            (found.slip[end] - found.relaxed[end])
            * wheel.along
            / self.tyres[end].relaxation_length(found.load[end], x[..., 0])
            for end, wheel in found.wheels.items()
        ]
        found.rates = np.concatenate(
            [found.acceleration[..., self.moving], found.w[..., self.angles], np.stack(slip_rates, -1)], axis=-1
        )
        return found

    @staticmethod
    def _constraints(wheels: Collection[Contact]) -> np.ndarray:
        return np.stack([*(wheel.rises for wheel in wheels), *(wheel.rolls for wheel in wheels)], axis=-2)

    @staticmethod
    def _unit_forces(found: SimpleNamespace) -> np.ndarray:
        """The generalised forces (..., n, 4) of a unit side force and a unit moment about z at each wheel."""
        wheels = list(found.wheels.values())
        sideways = [(wheel.right[..., None, :] @ wheel.shift)[..., 0, :] for wheel in wheels]
        return np.stack([*sideways, *(wheel.turn[..., 2, :] for wheel in wheels)], axis=-1)

    def side_forces(self, found: SimpleNamespace, multipliers: np.ndarray) -> np.ndarray:
        """The side forces (..., 2) [N] at loads and longitudinal forces (..., 4)."""
        return self._tyre_forces(found, multipliers[..., :2])[..., :2]

    def _tyre_forces(self, found: SimpleNamespace, load: np.ndarray) -> np.ndarray:
        """(Y_f, Y_r, M_f, M_r) at loads (..., 2)."""
        each = [
            self.tyres[end].forces(load[..., i], found.relaxed[end], wheel.camber)
            for i, (end, wheel) in enumerate(found.wheels.items())
        ]
        return np.stack([each[0][0], each[1][0], each[0][1], each[1][1]], axis=-1)

    def _consistent_forces(self, found: SimpleNamespace, by_force: np.ndarray) -> np.ndarray:
        """(Y_f, Y_r, M_f, M_r) that agree with the loads that they cause, by_force (1, Y_f, Y_r, M_f, M_r): Newton's
        method.
        """
        load = np.stack(
            [np.full(by_force.shape[:-2], tyre.nominal_load, by_force.dtype) for tyre in self.tyres.values()], axis=-1
        )
        for _ in range(ITERATIONS):
            now = self._tyre_forces(found, load)
            per_load = (self._tyre_forces(found, load * (1 + 1e-7)) - now) / (
                1e-7 * np.concatenate([load, load], axis=-1)
            )
            excess = load - by_force[..., 0] - (by_force[..., 1:] @ now[..., None])[..., 0]
            slopes = (
                np.eye(2) - by_force[..., 1:3] * per_load[..., None, :2] - by_force[..., 3:] * per_load[..., None, 2:]
            )
            found.determinacy = np.linalg.det(slopes).real
            change = np.linalg.solve(slopes, excess[..., None])[..., 0]
            load = load - change
            if _small(change / 1e3):
                break
        return self._tyre_forces(found, load)

    # Forces -----------------------------------------------------------------------------------------

    def forces(self, found: SimpleNamespace, u: np.ndarray) -> dict[str, np.ndarray]:
        """The given generalised forces (..., n) by what they are: all but the tyres'."""
        p, motion, w = self.values, found.motion, found.w
        drive, steer_torque, handlebar, on_frame = np.moveaxis(u, -1, 0)
        frame, steer, rear = self.place["pitch"], self.place["steer"], self.place["rear_spin"]
        squared = (w[..., self.place["along"]] ** 2)[..., None]
        shift, turn = self.tree.jacobians(motion, frame, self._reference(motion))
        wind = -p.drag * AHEAD - p.lift * DOWN
        aerodynamic = squared * (wind @ shift + p.pitching_moment * turn[..., 1, :])
        springs, dampers, driven, steered = (np.zeros_like(found.q) for _ in range(4))
        for name in self.free:
            k, values = self.place[name], p.__dict__
            springs[..., k] = -values[f"{name}_stiffness"] * found.q[..., k]
            dampers[..., k] = -values[f"{name}_damping"] * w[..., k]
        dampers[..., steer] = -p.steering_damping * w[..., steer]
        driven[..., rear] = drive
        axis = motion.axis[..., steer, :]
        _, front_turn = self.tree.jacobians(motion, steer, motion.joint[..., steer, :])
        at_bar = handlebar[..., None] * (axis[..., None, :] @ front_turn)[..., 0, :]
        at_bar = at_bar + on_frame[..., None] * (axis[..., None, :] @ turn)[..., 0, :]
        steered[..., steer] = steer_torque
        return {
            "weight": p.gravity * found.weight,
            "aerodynamic": aerodynamic,
            "springs": springs,
            "dampers": dampers,
            "drive": driven,
            "steer_torque": steered,
            "handlebar_port": at_bar,
        }

    def _reference(self, motion: Motion) -> np.ndarray:
        frame = self.place["pitch"]
        return motion.joint[..., frame, :] - self.values.reference_height * motion.turned[..., frame, :, 2]

    def outputs(self, found: SimpleNamespace) -> dict[str, np.ndarray]:
        """OUTPUTS (...) by name."""
        motion, place = found.motion, self.place
        frame_rate = dot(motion.omega[..., place["pitch"], :], motion.axis[..., place["steer"], :])
        tyres = {f"{end}_{name}": getattr(found, name)[end] for end in ENDS for name in ("side_force", "load")}
        return {
            "roll_angle": found.q[..., place["roll"]],
            "roll_rate": found.w[..., place["roll"]],
            "steer_angle": found.q[..., place["steer"]],
            "steer_rate": found.w[..., place["steer"]],
            "frame_rate": frame_rate,
            "yaw_rate": found.w[..., place["yaw"]],
            "lateral_velocity": found.w[..., place["lateral"]],
            **tyres,
        }


def _small(change: np.ndarray) -> bool:
    """Whether Newton's method has converged: its next change is the square of one this small (of values of the size
    of 1).
    """
    return bool((np.abs(change.real) < CONVERGED).all())
