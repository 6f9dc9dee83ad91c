r"""The touring motorcycle in large motion on a flat road: rigid bodies, rolling toroidal wheels, Magic Formula tyres.

Coordinates: along, lateral and vertical position of the point A on the ground, yaw, lean (roll about the heading),
pitch about the axle direction through A, then the freedoms of `vehicle_fmu.components.touring_motorcycle` and of
`vehicle_fmu.large_motion.suspension` that are free, and the wheels' spin. The equations do not depend on position and
yaw, which are 0 here; u, v are the velocities of A along and across the heading.

Each tyre has a deflection delta and a longitudinal slip kappa (`vehicle_fmu.large_motion.contact`): four conditions
C(kappa) w = (-delta', 0), which give the vertical, pitch and spin motion. The loads Z act along the rows of -delta',
the longitudinal forces X_l along rows P, and side forces Y(Z, alpha', gamma, kappa) and moments beside them:

    M (w' + e) + h = Q + P^T (Z, X_l),    C (w' + e) + g = (-delta'', -t.X' kappa'),    e = (-v r, u r, 0, ...)
    slip angle     alpha = -atan(n.X' / t.X')
    relaxation     alpha'' = (alpha - alpha') t.X' / sigma(Z, u)        (alpha'' : rate of alpha')

A deflection or slip that is free is a state, and its force is that of the tyre
(`vehicle_fmu.large_motion.tyre_forces`); one that is locked is 0, and its force is the multiplier of its condition.

Source: as in `vehicle_fmu.components.touring_motorcycle`; torus on a plane as in Lot, Meccanica 39 (2004) 481-496;
Lagrange's equations with multipliers in quasi-velocities as in Kane, Levinson (1985).
"""

from collections.abc import Collection
from types import SimpleNamespace

import numpy as np

from fmus.declaration.component import Component
from vehicle_fmu.large_motion.applied_forces import AppliedForces
from vehicle_fmu.large_motion.contact import Contact, Wheel, contact, dot
from vehicle_fmu.large_motion.magic_formula import Tyre
from vehicle_fmu.large_motion.touring_tree import ENDS, SPRUNG, touring_tree, tyre
from vehicle_fmu.large_motion.tree import Motion, Tree
from vehicle_fmu.large_motion.tyre_forces import TyreForces, small

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
ITERATIONS = 30


class LargeMotion:
    """x' = f(x, u) of a touring motorcycle, for stacked states (..., nx) and inputs (..., nu); order of `states` and
    `vehicle_fmu.large_motion.applied_forces.INPUTS`.
    """

    def __init__(self, motorcycle: Component):
        self.values = SimpleNamespace(**motorcycle.values, **motorcycle.supplement)
        self.tree: Tree = touring_tree(motorcycle)
        self.tyres: dict[str, Tyre] = {end: tyre(motorcycle, end) for end in ENDS}
        self.place = self.tree.place
        self.free = [link.name for link in self.tree.links if link.name in SPRUNG]
        self.applied = AppliedForces(self.tree, self.values, self.free)
        deflections, slips = (
            [self._is_free(f"{end}_{name}") for end in ENDS] for name in ("tyre_deflection", "longitudinal_slip")
        )
        self.condition_free = np.array(deflections + slips)
        self.by_tyres = TyreForces(self.tyres, vars(self.values), self.condition_free)
        self.moving = [self.place[name] for name in ("along", "lateral", "yaw", "roll", "steer", *self.free)]
        self.dependent = [self.place[name] for name in ("vertical", "pitch", "front_spin", "rear_spin")]
        self.angles = [self.place[name] for name in ("roll", "steer", *self.free)]
        free_tyres = [f"{end}_tyre_deflection" for end, free in zip(ENDS, deflections, strict=True) if free]
        self.states = (
            "forward_speed",
            "lateral_velocity",
            "yaw_rate",
            "roll_rate",
            "steer_rate",
            *(f"{n}_rate" for n in (*self.free, *free_tyres)),
            "roll_angle",
            "steer_angle",
            *(f"{n}_position" for n in (*self.free, *free_tyres)),
            *(f"{end}_longitudinal_slip" for end, free in zip(ENDS, slips, strict=True) if free),
            "front_relaxed_slip",
            "rear_relaxed_slip",
        )
        self.wheels = {end: self._wheel(end) for end in ENDS}

    def _is_free(self, name: str) -> bool:
        return bool(vars(self.values)[name])

    def _wheel(self, end: str) -> Wheel:
        spin = self.place[f"{end}_spin"]
        height = -float(self.tree.links[spin].point[2])
        radius = vars(self.values)[f"{end}_wheel_radius"]
        return Wheel(self.tree.parent[spin], spin, height, self.tyres[end].section_radius, radius)

    # Kinematics -------------------------------------------------------------------------------------

    def _of_tyres(self, x: np.ndarray, ending: str) -> np.ndarray:
        """The states (..., 2) of both tyres of that name; 0 where locked."""
        names = [f"{end}_{ending}" for end in ENDS]
        columns = [x[..., self.states.index(n)] if n in self.states else np.zeros(x.shape[:-1], x.dtype) for n in names]
        return np.stack(columns, axis=-1)

    def coordinates(self, x: np.ndarray, guess: np.ndarray | float = 0.0) -> np.ndarray:
        """The coordinates (..., n) at states (..., nx), with height and pitch, near a guess, at which both tyres have
        their deflections.
        """
        q = np.zeros((*x.shape[:-1], len(self.tree.links)), x.dtype)
        first = self.states.index("roll_angle")
        q[..., self.angles] = x[..., first : first + len(self.angles)]
        pair, wanted = self.dependent[:2], self._of_tyres(x, "tyre_deflection_position")
        q[..., pair] = guess
        for _ in range(ITERATIONS):
            motion = self.tree.motion(q, np.zeros_like(q))
            wheels = self._contacts(motion, np.zeros_like(wanted)).values()
            excess = np.stack([wheel.deflection for wheel in wheels], axis=-1) - wanted
            slopes = np.stack([wheel.shift[..., 2, pair] for wheel in wheels], axis=-2)
            change = np.linalg.solve(slopes, excess[..., None])[..., 0]
            q[..., pair] -= change
            if small(change):
                break
        return q

    def _contacts(self, motion: Motion, ratios: np.ndarray) -> dict[str, Contact]:
        return {
            end: contact(wheel, self.tree, motion, ratios[..., k]) for k, (end, wheel) in enumerate(self.wheels.items())
        }

    # Motion -----------------------------------------------------------------------------------------

    def posed(
        self, x: np.ndarray, u: np.ndarray, guess: np.ndarray | float = 0.0, acceleration: float = 0.0
    ) -> SimpleNamespace:
        """What states (..., nx) and inputs (..., nu) say without accelerations: coordinates q, rates w, wheels, slip
        angles, the rows of conditions and of their forces, the mass matrix, and the generalised forces (..., n)
        `given`, of all but the tyres, less M e + h, and less those of a forward `acceleration` [m/s2] at constant slip.
        """
        q, ratios = self.coordinates(x, guess), self._of_tyres(x, "longitudinal_slip")
        w = np.zeros_like(q)
        w[..., self.moving] = x[..., : len(self.moving)]
        still = self.tree.motion(q, np.zeros_like(q))
        rows = self._rows(self._contacts(still, ratios).values(), "rolls")
        sinking = self._of_tyres(x, "tyre_deflection_rate")
        wanted = np.concatenate([-sinking, np.zeros_like(sinking)], axis=-1)
        w[..., self.dependent] = self._by_conditions(rows, w, wanted)
        motion = self.tree.motion(q, w)
        wheels = self._contacts(motion, ratios)
        yaw, turning = w[..., self.place["yaw"]], np.zeros_like(w)
        turning[..., self.place["along"]] = -w[..., self.place["lateral"]] * yaw
        turning[..., self.place["lateral"]] = w[..., self.place["along"]] * yaw
        accelerating = np.zeros_like(w)
        accelerating[..., self.place["along"]] = acceleration
        accelerating[..., self.dependent] = self._by_conditions(rows, accelerating, np.zeros_like(wanted))
        mass, bias, weight = self.tree.inertia_terms(motion)
        found = SimpleNamespace(
            q=q,
            w=w,
            motion=motion,
            wheels=wheels,
            rows=rows,
            push=self._rows(wheels.values(), "slides"),
            turning=turning,
            mass=mass,
            weight=weight,
            ratio=dict(zip(ENDS, np.moveaxis(ratios, -1, 0), strict=True)),
            sunk=dict(zip(ENDS, np.moveaxis(self._of_tyres(x, "tyre_deflection_position"), -1, 0), strict=True)),
            sinking=dict(zip(ENDS, np.moveaxis(sinking, -1, 0), strict=True)),
            relaxed=dict(zip(ENDS, np.moveaxis(x[..., -2:], -1, 0), strict=True)),
            slip={end: -np.arctan(wheel.across / wheel.along) for end, wheel in wheels.items()},
        )
        found.given = sum(self.forces(found, u).values()) - bias - (mass @ (turning + accelerating)[..., None])[..., 0]
        return found

    def forces(self, found: SimpleNamespace, u: np.ndarray) -> dict[str, np.ndarray]:
        """The applied generalised forces (..., n) by what they are: all but the tyres'."""
        return self.applied(found.motion, found.q, found.w, found.weight, u)

    def _by_conditions(self, rows: np.ndarray, w: np.ndarray, wanted: np.ndarray) -> np.ndarray:
        """The dependent rates (..., 4) with which rates w (..., n) meet C w = wanted (..., 4)."""
        return np.linalg.solve(rows[..., self.dependent], (wanted - (rows @ w[..., None])[..., 0])[..., None])[..., 0]

    def imbalance(
        self, x: np.ndarray, u: np.ndarray, multipliers: np.ndarray, guess: np.ndarray | float = 0.0,
        acceleration: float = 0.0,
    ) -> np.ndarray:  # fmt: skip
        """The generalised forces (..., n) that are left where no rate but the forward speed changes, by a given
        acceleration, and what the slip angles lack of their relaxed values (..., 2), with loads and longitudinal forces
        (..., 4) given where their conditions are locked.
        """
        found = self.posed(x, u, guess, acceleration)
        multipliers = self.by_tyres.at_contacts(found, multipliers)
        forces = self.by_tyres(found, multipliers[..., :2])[..., :4]
        by_tyres = (self._unit_forces(found)[..., :4] @ forces[..., None])[..., 0]
        by_tyres = by_tyres + (multipliers[..., None, :] @ found.push)[..., 0, :]
        lag = [found.slip[end] - found.relaxed[end] for end in ENDS]
        return np.concatenate([found.given + by_tyres, np.stack(lag, axis=-1)], axis=-1)

    def at(self, x: np.ndarray, u: np.ndarray, guess: np.ndarray | float = 0.0) -> SimpleNamespace:
        """What `posed` finds, and accelerations w', loads, longitudinal and side forces, moments, and the `rates` of
        the states.
        """
        found = self.posed(x, u, guess)
        n, free = found.mass.shape[-1], self.condition_free
        left = np.zeros((*found.mass.shape[:-2], n + 4, n + 4), found.mass.dtype)
        left[..., :n, :n], left[..., :n, n:], left[..., n:, :n] = found.mass, -found.push.swapaxes(-1, -2), found.rows
        along = [wheel.along for wheel in found.wheels.values()]
        for k in np.flatnonzero(free):  # its force is known, its acceleration not
            left[..., :n, n + k], left[..., n + k, n + k] = 0.0, 1.0 if k < 2 else along[k - 2]
        law = self.by_tyres.loads(found) * free[:2]
        right = np.zeros((*found.mass.shape[:-2], n + 4, 7), found.mass.dtype)
        right[..., :n, 0] = found.given + (law[..., None, :] @ found.push[..., :2, :])[..., 0, :]
        right[..., :n, 1:] = self._unit_forces(found)
        bias = [getattr(wheel, name) for name in ("rise_bias", "roll_bias") for wheel in found.wheels.values()]
        right[..., n:, 0] = -np.stack(bias, axis=-1) - (found.rows @ found.turning[..., None])[..., 0]
        solved = np.linalg.solve(left, right)
        by_force = solved[..., n : n + 2, :].copy()
        by_force[..., free[:2], :], by_force[..., free[:2], 0] = 0.0, law[..., free[:2]]
        load, forces = self.by_tyres.consistent(found, by_force)
        unknowns = solved[..., 0] + (solved[..., 1:] @ forces[..., None])[..., 0]
        found.acceleration = unknowns[..., :n]
        push = np.where(free[2:], forces[..., 4:], unknowns[..., n + 2 :])
        for name, values in (
            ("load", load),
            ("longitudinal_force", push),
            ("side_force", forces),
            ("yaw_moment", forces[..., 2:]),
        ):
            setattr(found, name, {end: values[..., i] for i, end in enumerate(ENDS)})
        slip_rates = [
            (found.slip[end] - found.relaxed[end])
            * wheel.along
            / self.tyres[end].relaxation_length(found.load[end], x[..., 0])
            for end, wheel in found.wheels.items()
        ]
        own = unknowns[..., n:][..., free]
        sinking, many = x[..., len(self.moving) : self.states.index("roll_angle")], int(free[:2].sum())
        found.rates = np.concatenate(
            [found.acceleration[..., self.moving], own[..., :many], found.w[..., self.angles], sinking, own[..., many:],
             np.stack(slip_rates, -1)], axis=-1)  # fmt: skip
        return found

    # Tyres ------------------------------------------------------------------------------------------

    @staticmethod
    def _rows(wheels: Collection[Contact], lengthwise: str) -> np.ndarray:
        return np.stack([*(w.rises for w in wheels), *(getattr(w, lengthwise) for w in wheels)], axis=-2)

    def _unit_forces(self, found: SimpleNamespace) -> np.ndarray:
        """The generalised forces (..., n, 6) of a unit side force and a unit moment about z at each wheel, and of a
        unit longitudinal force where its slip is free.
        """
        wheels = list(found.wheels.values())
        sideways = [(wheel.right[..., None, :] @ wheel.shift)[..., 0, :] for wheel in wheels]
        lengthwise = [wheel.slides * free for wheel, free in zip(wheels, self.condition_free[2:], strict=True)]
        return np.stack([*sideways, *(wheel.turn[..., 2, :] for wheel in wheels), *lengthwise], axis=-1)

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
