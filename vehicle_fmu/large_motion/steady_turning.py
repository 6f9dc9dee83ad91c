r"""Steady turning and steady acceleration: the equilibrium of the touring motorcycle at a speed, a lean angle and a
longitudinal acceleration, followed from straight running.

Unknowns y: lateral velocity, yaw rate, steer angle, the free positions, deflections and longitudinal slips, both
relaxed slip angles, the loads and longitudinal forces of locked conditions, and two torques: of steering, and T of
drive or brakes. At an equilibrium the rates of all states but the angles, whose rates are 0, are

    f(x, u) = (a, 0, ..., 0)

with the longitudinal acceleration a of the point A along the heading (quasi-equilibrium: the speed changes so slowly
that all other rates are 0). T >= 0 drives the rear wheel; T < 0 brakes the front wheel with the share
`front_brake_share` and the rear wheel with the rest.

Newton's method with the derivatives of `LargeMotion` (complex steps). Each lean angle, and then at that lean angle each
acceleration, is predicted by the straight line through the two before it (secant predictor; Allgower, Georg,
Introduction to Numerical Continuation Methods (2003)). Steps are halved where Newton's method does not converge; below
the smallest step the equilibrium ends. It also ends where a wheel has no load (wheelie, stoppie), and where a tyre is
beyond its greatest side force or longitudinal force.
"""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from fmus.support.errors import InputError
from vehicle_fmu.large_motion.applied_forces import INPUTS
from vehicle_fmu.large_motion.equations import ENDS, LargeMotion

LEAN, ACCELERATION = "lean", "acceleration"
LARGEST_STEP = {LEAN: np.radians(5.0), ACCELERATION: 1.0}  # rad, m/s2
SMALLEST_STEP = {LEAN: np.radians(0.2), ACCELERATION: 0.02}
AT_REST = 1e-5  # m/s2, rad/s2, rad/s: rates that an equilibrium leaves are below 1e-7
SAME = 1e-12  # rad, m/s2: values that differ by rounding
ITERATIONS, LEAST_SHARE = 12, 1 / 16  # of Newton's method; of its step
CONVERGED = 1e-8  # N, N.m, rad: largest imbalance; rounding of weights of 2500 N and of stiff springs is 1e-10
COMPLEX_STEP = 1e-30
NEARLY_ALL = 0.98  # of the greatest force, above which a loss of equilibrium is due to the grip
NEARLY_NONE = 0.1  # of the load upright, below which it is due to the load


@dataclass(frozen=True)
class Equilibrium:
    """Steady motion at a lean angle [rad] and a longitudinal acceleration [m/s2]: states x (nx,), inputs u (nu,), loads
    and longitudinal forces (4,) [N], the values of all unknowns, the largest force or moment that is left [N, N.m], and
    what `LargeMotion.posed` finds there.
    """

    lean: float
    acceleration: float
    x: np.ndarray
    u: np.ndarray
    multipliers: np.ndarray
    unknowns: np.ndarray
    residual: float
    found: SimpleNamespace

    @property
    def load(self) -> dict[str, float]:
        """The load on each tyre [N]."""
        return dict(zip(ENDS, self.multipliers[:2].tolist(), strict=True))

    @property
    def longitudinal_force(self) -> dict[str, float]:
        """The longitudinal force of each tyre [N], positive forward."""
        return dict(zip(ENDS, self.multipliers[2:].tolist(), strict=True))


class SteadyTurning:
    """The equilibria of a motorcycle at a speed [m/s] over the lean angle, to the right positive, and acceleration."""

    def __init__(self, motion: LargeMotion, speed: float):
        self.motion, self.speed = motion, speed
        names = motion.states
        self.lean = names.index("roll_angle")
        self.unknown = [
            k
            for k, n in enumerate(names)
            if k != self.lean
            and not n.endswith(("forward_speed", "roll_rate"))
            and (not n.endswith("_rate") or n == "yaw_rate")
        ]
        self.locked = np.flatnonzero(~motion.condition_free)
        self.torques = [INPUTS.index("drive_torque"), INPUTS.index("steer_torque")]
        drag = motion.values.drag * speed**2
        loads = [tyre.nominal_load for tyre in motion.tyres.values()]
        start = np.zeros(len(self.unknown) + 2 + len(self.locked))
        start[len(self.unknown)] = drag * motion.values.rear_wheel_radius
        start[len(self.unknown) + 2 :] = np.array([*loads, 0.0, 0.0])[self.locked]
        upright = self._newton(0.0, 0.0, start)
        if upright is None:
            raise InputError(f"no equilibrium at {speed:g} m/s, upright: drag or lift unloads a wheel")
        self.known, self.accelerated = [upright], list[Equilibrium]()

    def at(self, lean: float, acceleration: float = 0.0) -> Equilibrium:
        """The equilibrium at a lean angle [rad] and a longitudinal acceleration [m/s2]. Raises InputError, with the
        last lean angle or acceleration that has one and the reason, where there is none.
        """
        level = self._followed(self.known, LEAN, lean, 0.0)
        if abs(acceleration) < SAME:
            return level
        at_this_lean = [level, *(e for e in self.accelerated if e.lean == level.lean)]
        many = len(at_this_lean)
        try:
            return self._followed(at_this_lean, ACCELERATION, acceleration, level.lean)
        finally:
            self.accelerated += at_this_lean[many:]

    def _followed(self, known: list[Equilibrium], kind: str, wanted: float, lean: float) -> Equilibrium:
        """The equilibrium with a lean angle or an acceleration, from `known` ones, to which those found are added."""

        def value(equilibrium: Equilibrium) -> float:
            return float(getattr(equilibrium, kind))

        side = sorted((e for e in known if value(e) * wanted >= 0), key=lambda e: abs(value(e)))
        near = [e for e in side if abs(value(e)) <= abs(wanted) + SAME]
        if abs(value(near[-1]) - wanted) < SAME:
            return near[-1]
        before, last = near[-2:] if len(near) > 1 else (None, near[-1])
        while value(last) != wanted:
            step = np.clip(wanted - value(last), -LARGEST_STEP[kind], LARGEST_STEP[kind])
            while True:
                there = value(last) + step if abs(wanted - value(last)) > abs(step) else wanted
                share = 0.0 if before is None else (there - value(last)) / (value(last) - value(before))
                guess = last.unknowns + (share * (last.unknowns - before.unknowns) if before else 0.0)
                if (found := self._newton(*self._point(kind, there, lean), guess, last)) is not None:
                    break
                step /= 2
                if abs(step) < SMALLEST_STEP[kind]:
                    raise InputError(self._no_equilibrium(kind, wanted, last))
            before, last = last, found
            known.append(found)
        return last

    @staticmethod
    def _point(kind: str, value: float, lean: float) -> tuple[float, float]:
        return (value, 0.0) if kind == LEAN else (lean, value)

    def linearised(self, equilibrium: Equilibrium) -> tuple[np.ndarray, ...]:
        """A, B, C, D about an equilibrium, for the states, INPUTS and OUTPUTS of `equations`.

        Raises InputError where side forces that follow the loads at once leave the loads undetermined: the determinant
        of what the loads lack, by the loads, is 1 upright, falls with the lean angle, and is positive where they are.
        Where it has passed 0, other loads with other accelerations may be found at the same state. Tyres that deflect
        determine their loads.
        """
        x, u = equilibrium.x, equilibrium.u
        many = len(x) + len(u)
        steps = 1j * COMPLEX_STEP * np.eye(many)
        guess = equilibrium.found.q[self.motion.dependent[:2]]
        found = self.motion.at(x + steps[:, : len(x)], u + steps[:, len(x) :], guess)
        left = found.rates.real - np.where(np.arange(len(x)) == 0, equilibrium.acceleration, 0.0)
        if not ((found.determinacy > 0).all() and np.abs(left).max() < AT_REST):
            lean = np.degrees(equilibrium.lean)
            raise InputError(
                f"no modes at {self.speed:g} m/s and a lean angle of {lean:.1f} deg: there is an equilibrium, but with "
                "rigid tyres its motion does not determine the loads; give a smaller lean angle, or free both tyre "
                "deflections"
            )
        outputs = np.stack(list(self.motion.outputs(found).values()), axis=-1)
        rates, outputs = (part.imag.T / COMPLEX_STEP for part in (found.rates, outputs))
        return rates[:, : len(x)], rates[:, len(x) :], outputs[:, : len(x)], outputs[:, len(x) :]

    def _newton(
        self, lean: float, acceleration: float, unknowns: np.ndarray, near: Equilibrium | None = None
    ) -> Equilibrium | None:
        """The equilibrium near values of the unknowns; None where the iteration does not converge to one with load
        and grip.
        """
        last, change, share = np.inf, np.zeros_like(unknowns), 1.0
        guess = near.found.q[self.motion.dependent[:2]] if near else 0.0
        for _ in range(ITERATIONS):
            left, slopes = self._slopes(lean, acceleration, unknowns + share * change, guess)
            size = float(np.linalg.norm(left))
            if not size < last:
                share /= 2
                if share < LEAST_SHARE:
                    return None
                continue
            unknowns = unknowns + share * change
            if np.abs(left).max() < CONVERGED:
                x, u, forces = self._placed(lean, unknowns)
                found = self.motion.posed(x, u, guess)
                forces = self.motion.by_tyres.at_contacts(found, forces)
                residual = float(np.abs(left).max())
                equilibrium = Equilibrium(lean, acceleration, x, u, forces, unknowns, residual, found)
                return equilibrium if self._holds(equilibrium) else None
            change, share, last = -np.linalg.lstsq(slopes, left, rcond=None)[0], 1.0, size
        return None

    def _placed(self, lean: float, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """States (..., nx), inputs (..., nu), loads and longitudinal forces (..., 4) of locked conditions, of values of
        the unknowns (..., n).
        """
        shape, count = unknowns.shape[:-1], len(self.unknown)
        x, u = (np.zeros((*shape, len(names)), unknowns.dtype) for names in (self.motion.states, INPUTS))
        x[..., 0], x[..., self.lean], x[..., self.unknown] = self.speed, lean, unknowns[..., :count]
        u[..., self.torques] = unknowns[..., count : count + 2]
        brakes = u[..., self.torques[0]] * (u[..., self.torques[0]].real < 0)
        at_front = self.motion.values.front_brake_share * brakes
        u[..., INPUTS.index("front_wheel_torque")] = at_front
        u[..., self.torques[0]] -= at_front
        forces = np.zeros((*shape, 4), unknowns.dtype)
        forces[..., self.locked] = unknowns[..., count + 2 :]
        return x, u, forces

    def _slopes(
        self, lean: float, acceleration: float, unknowns: np.ndarray, guess: np.ndarray | float
    ) -> tuple[np.ndarray, np.ndarray]:
        """The imbalance (n,) and its derivatives (n, n) by the unknowns."""
        points = unknowns + 1j * COMPLEX_STEP * np.eye(len(unknowns))
        with np.errstate(all="ignore"):
            left = self.motion.imbalance(*self._placed(lean, points), guess, acceleration)
        return left[0].real, left.imag.T / COMPLEX_STEP

    # Grip and load ----------------------------------------------------------------------------------

    def _holds(self, equilibrium: Equilibrium) -> bool:
        if min(equilibrium.load.values()) <= 0:
            return False
        return all(abs(use) < np.pi / 2 for use in self._uses(equilibrium).values())

    def _uses(self, equilibrium: Equilibrium) -> dict[tuple[str, str], float]:
        """The arguments of the sines in side and longitudinal force of each tyre [rad]: pi / 2 at its greatest
        force."""
        found, load, uses = equilibrium.found, equilibrium.load, {}
        for end, tyre in self.motion.tyres.items():
            uses[end, "side"] = float(tyre.use(load[end], found.relaxed[end], found.wheels[end].camber)[1])
            uses[end, "longitudinal"] = float(tyre.longitudinal_use(load[end], found.ratio[end])[1])
        return uses

    def grip_used(self, equilibrium: Equilibrium) -> dict[str, float]:
        """The root of the squared side and longitudinal force of each tyre, each per the greatest one at its load."""
        side = self.motion.by_tyres(equilibrium.found, equilibrium.multipliers[:2])[:2]
        used = {}
        for k, (end, tyre) in enumerate(self.motion.tyres.items()):
            load, camber = equilibrium.load[end], equilibrium.found.wheels[end].camber
            greatest = float(tyre.use(load, 0.0, camber)[0]), float(tyre.longitudinal_use(load, 0.0)[0])
            used[end] = float(np.hypot(side[k] / greatest[0], equilibrium.longitudinal_force[end] / greatest[1]))
        return used

    def _no_equilibrium(self, kind: str, wanted: float, last: Equilibrium) -> str:
        if kind == LEAN:
            asked, end = f"a lean angle of {np.degrees(wanted):g} deg", f"{np.degrees(last.lean):.1f} deg"
            return (f"no steady turning at {self.speed:g} m/s and {asked}: equilibria end near {end}, "
                    f"where {self._reason(last)}")  # fmt: skip
        return (
            f"no equilibrium at {self.speed:g} m/s, a lean angle of {np.degrees(last.lean):g} deg and a longitudinal "
            f"acceleration of {wanted:g} m/s2: equilibria end near {last.acceleration:.2f} m/s2, "
            f"where {self._reason(last)}"
        )

    def _reason(self, last: Equilibrium) -> str:
        upright = self.known[0].load
        for end, name in zip(ENDS, ("wheelie", "stoppie"), strict=True):
            if last.load[end] < NEARLY_NONE * upright[end]:
                return f"the {end} wheel carries {last.load[end]:.0f} N ({name})"
        (end, force), use = max(self._uses(last).items(), key=lambda each: abs(each[1]))
        if np.sin(abs(use)) > NEARLY_ALL:
            return f"the {end} tyre gives {100 * np.sin(abs(use)):.0f} % of its greatest {force} force"
        if last.acceleration:
            end, used = max(self.grip_used(last).items(), key=lambda each: each[1])
            return f"the {end} tyre uses {100 * used:.0f} % of its grip and Newton's method has no solution beyond it"
        steer = np.degrees(last.found.q[self.motion.place["steer"]])
        return f"the steer angle is {steer:.1f} deg and Newton's method has no solution beyond it"
