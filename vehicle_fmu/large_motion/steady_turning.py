r"""Steady turning: the equilibrium of the touring motorcycle at a speed and a lean angle, followed from straight
running.

Unknowns y: lateral velocity, yaw rate, steer angle, the flexible freedoms, both relaxed slip angles, and the torques
of drive and steering. At an equilibrium the rates of forward and lateral velocity, yaw, lean, steer, flexible
freedoms and slips are 0:

    f(x, u) = 0 without the rows of the angles, whose rates are 0

by Newton's method with the derivatives of `at` (complex steps), each lean angle predicted by the straight line
through the two before it (secant predictor; Allgower, Georg, Introduction to Numerical Continuation Methods (2003)).
Steps are halved where Newton's method does not converge; below the smallest step the equilibrium ends. It also ends
where a wheel has no load, and where a tyre is beyond its greatest side force.
"""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from fmus.support.errors import InputError
from vehicle_fmu.large_motion.equations import ENDS, INPUTS, LargeMotion

LARGEST_STEP, SMALLEST_STEP = np.radians(5.0), np.radians(0.2)  # of the lean angle
AT_REST = 1e-5  # m/s2, rad/s2, rad/s: rates that an equilibrium leaves are below 1e-7
SAME = 1e-12  # rad: lean angles that differ by rounding
ITERATIONS, LEAST_SHARE = 12, 1 / 16  # of Newton's method; of its step
CONVERGED = 1e-8  # N, N.m, rad: largest imbalance; rounding of weights of 2500 N and of stiff springs is 1e-10
COMPLEX_STEP = 1e-30
NEARLY_ALL = 0.98  # of the greatest side force, above which a loss of equilibrium is due to the grip
NEARLY_NONE = 0.05  # of the load upright, below which it is due to the load


@dataclass(frozen=True)
class Equilibrium:
    """Steady turning at a lean angle [rad]: states x (nx,), inputs u (nu,), loads and longitudinal forces (4,) [N],
    the values of all unknowns, the largest force or moment that is left [N, N.m], and what `LargeMotion.posed` finds
    there.
    """

    lean: float
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


class SteadyTurning:
    """The equilibria of a motorcycle at a speed [m/s] over the lean angle, to the right positive."""

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
        self.torques = [INPUTS.index("drive_torque"), INPUTS.index("steer_torque")]
        drive = motion.values.drag * speed**2 * motion.values.rear_wheel_radius
        start = np.zeros(len(self.unknown) + 6)
        start[len(self.unknown)], start[-4:-2] = drive, [tyre.nominal_load for tyre in motion.tyres.values()]
        upright = self._newton(0.0, start)
        if upright is None:
            raise InputError(f"no equilibrium at {speed:g} m/s, upright: drag or lift unloads a wheel")
        self.known = [upright]

    def at(self, lean: float) -> Equilibrium:
        """The equilibrium at a lean angle [rad]. Raises InputError, with the last lean angle that has one, where
        there is none.
        """
        side = sorted((e for e in self.known if e.lean * lean >= 0), key=lambda e: abs(e.lean))
        near = [e for e in side if abs(e.lean) <= abs(lean) + SAME]
        if abs(near[-1].lean - lean) < SAME:
            return near[-1]
        before, last = near[-2:] if len(near) > 1 else (None, near[-1])
        while last.lean != lean:
            step = np.clip(lean - last.lean, -LARGEST_STEP, LARGEST_STEP)
            while (
                found := self._next(before, last, last.lean + step if abs(lean - last.lean) > abs(step) else lean)
            ) is None:
                step /= 2
                if abs(step) < SMALLEST_STEP:
                    raise InputError(
                        f"no steady turning at {self.speed:g} m/s and a lean angle of {np.degrees(lean):g} deg: "
                        f"equilibria end near {np.degrees(last.lean):.1f} deg, where {self._reason(last)}"
                    )
            before, last = last, found
            self.known.append(found)
        return last

    def linearised(self, equilibrium: Equilibrium) -> tuple[np.ndarray, ...]:
        """A, B, C, D about an equilibrium, for the states, INPUTS and OUTPUTS of `equations`.

        Raises InputError where side forces that follow the loads at once leave the loads undetermined: the determinant
        of what the loads lack, by the loads, is 1 upright, falls with the lean angle, and is positive where they are.
        Where it has passed 0, other loads with other accelerations may be found at the same state.
        """
        x, u = equilibrium.x, equilibrium.u
        many = len(x) + len(u)
        steps = 1j * COMPLEX_STEP * np.eye(many)
        guess = equilibrium.found.q[self.motion.dependent[:2]]
        found = self.motion.at(x + steps[:, : len(x)], u + steps[:, len(x) :], guess)
        if not ((found.determinacy > 0).all() and np.abs(found.rates.real).max() < AT_REST):
            lean = np.degrees(equilibrium.lean)
            raise InputError(
                f"no modes at {self.speed:g} m/s and a lean angle of {lean:.1f} deg: there is an equilibrium, but with "
                "rigid tyres and suspensions its motion does not determine the loads; give a smaller lean angle"
            )
        outputs = np.stack(list(self.motion.outputs(found).values()), axis=-1)
        rates, outputs = (part.imag.T / COMPLEX_STEP for part in (found.rates, outputs))
        return rates[:, : len(x)], rates[:, len(x) :], outputs[:, : len(x)], outputs[:, len(x) :]

    def _next(self, before: Equilibrium | None, last: Equilibrium, lean: float) -> Equilibrium | None:
        share = 0.0 if before is None else (lean - last.lean) / (last.lean - before.lean)
        return self._newton(lean, last.unknowns + (share * (last.unknowns - before.unknowns) if before else 0.0), last)

    def _newton(self, lean: float, unknowns: np.ndarray, near: Equilibrium | None = None) -> Equilibrium | None:
        """The equilibrium near values of the unknowns; None where the iteration does not converge to one with load
        and grip.
        """
        last, change, share = np.inf, np.zeros_like(unknowns), 1.0
        guess = near.found.q[self.motion.dependent[:2]] if near else 0.0
        for _ in range(ITERATIONS):
            left, slopes = self._slopes(lean, unknowns + share * change, guess)
            size = float(np.linalg.norm(left))
            if not size < last:
                share /= 2
                if share < LEAST_SHARE:
                    return None
                continue
            unknowns = unknowns + share * change
            if np.abs(left).max() < CONVERGED:
                x, u, loads = self._placed(lean, unknowns)
                found = self.motion.posed(x, u, guess)
                equilibrium = Equilibrium(lean, x, u, loads, unknowns, float(np.abs(left).max()), found)
                return equilibrium if self._holds(equilibrium) else None
            change, share, last = -np.linalg.lstsq(slopes, left, rcond=None)[0], 1.0, size
        return None

    def _placed(self, lean: float, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """States (..., nx), inputs (..., nu), loads and longitudinal forces (..., 4) of values of the unknowns (...,
        n).
        """
        shape, count = unknowns.shape[:-1], len(self.unknown)
        x, u = (np.zeros((*shape, len(names)), unknowns.dtype) for names in (self.motion.states, INPUTS))
        x[..., 0], x[..., self.lean], x[..., self.unknown] = self.speed, lean, unknowns[..., :count]
        u[..., self.torques] = unknowns[..., count:-4]
        return x, u, unknowns[..., -4:]

    def _slopes(self, lean: float, unknowns: np.ndarray, guess: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
        """The imbalance (n,) and its derivatives (n, n) by the unknowns."""
        points = unknowns + 1j * COMPLEX_STEP * np.eye(len(unknowns))
        with np.errstate(all="ignore"):
            left = self.motion.imbalance(*self._placed(lean, points), guess)
        return left[0].real, left.imag.T / COMPLEX_STEP

    def _holds(self, equilibrium: Equilibrium) -> bool:
        return all(
            load > 0 and abs(used) < 1
            for load, used in zip(equilibrium.load.values(), self.grip_used(equilibrium).values(), strict=True)
        )

    def grip_used(self, equilibrium: Equilibrium) -> dict[str, float]:
        """How far each tyre is on the way to its greatest side force: 1 where it has it, above 1 beyond it."""
        found, load = equilibrium.found, equilibrium.load
        return {
            end: abs(float(tyre.use(load[end], found.relaxed[end], found.wheels[end].camber)[1])) / (np.pi / 2)
            for end, tyre in self.motion.tyres.items()
        }

    def _reason(self, last: Equilibrium) -> str:
        upright = self.known[0].load
        for end, load in last.load.items():
            if load < NEARLY_NONE * upright[end]:
                return f"the {end} wheel carries {load:.0f} N"
        end, used = max(self.grip_used(last).items(), key=lambda each: each[1])
        if np.sin(used * np.pi / 2) > NEARLY_ALL:
            return f"the {end} tyre gives {100 * np.sin(used * np.pi / 2):.0f} % of its greatest side force"
        steer = np.degrees(last.found.q[self.motion.place["steer"]])
        return f"the steer angle is {steer:.1f} deg and Newton's method has no solution beyond it"
