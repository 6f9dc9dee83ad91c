"""What effects add to a vehicle that is not linear in its states, in a motion that is predicted from sample to sample.

    M x' = M (A x + B u) + f(x),     b(x) = M^-1 E f(x^ + sigma xi)

Where f depends on one state alone (friction on a rate), b is its expectation for the normal deviation sigma that the true
state has from the predicted one: a prediction that is a little off slides where the vehicle sticks.

Source: Gelb (ed.), Applied Optimal Estimation (1974), ch. 6.2, on statistical linearisation.
"""

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from fmus.component import Component
from fmus.effects import Effect
from fmus.linear import linearise
from fmus.mathematics import NUMERIC
from fmus.variables import Variable
from identification.gap.data.predicted import PredictedRun
from identification.gap.models.kalman import Bend
from identification.gap.stands.linear_stand import LinearStand

LARGE = 0.1  # deflection [rad] and rate [rad/s] at which an effect's slopes differ from those at rest if it is not linear
SPEED = 10.0  # m/s at which is looked for what it depends on
ROUNDING = 1e-9
NUDGE = 1e-6  # of a state's largest value
GRID = 1001  # places between which what depends on one state is interpolated
NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(9)  # of a normal distribution


class NotLinear:
    """The difference of a component and of the same without what is not linear, as a push on the rates of `rows`.

    over is the input that says the speed; effects holds the rows of the effects' parameters by name.
    """

    def __init__(self, component: Component, straight: Component, over: str, effects: Mapping[str, Variable]):
        self.component, self.straight, self.over, self.effects = component, straight, over, effects
        entries = straight.mass_entries({**straight.start_values(), **straight.values}, NUMERIC)
        self.rows = tuple(n for n in straight.states if any(n in place for place in entries))  # those that the mass matrix couples

    def near(self, run: PredictedRun, values: Mapping[str, float], motion: np.ndarray, unsure: np.ndarray) -> Bend:
        """b and its slopes by the states near a motion (n, nx)."""
        value = self.expected(run, values, motion, unsure)
        slope = np.zeros((*value.shape, motion.shape[1]))
        for i in self.felt:
            step = NUDGE * max(float(np.abs(motion[:, i]).max()), NUDGE)
            moved = motion.copy()
            moved[:, i] += step
            slope[..., i] = (self.expected(run, values, moved, unsure) - value) / step
        return Bend(value - (slope @ motion[..., None])[..., 0], slope)

    def expected(self, run: PredictedRun, values: Mapping[str, float], motion: np.ndarray, unsure: np.ndarray) -> np.ndarray:
        """b (n, nb) in a motion (n, nx), whose states are known to unsure (nx,)."""
        speed = run.averaged(run.recording[run.over])
        mean = float(run.speeds[0].mean())
        if len(self.felt) != 1:
            return self._push(values, motion, speed, mean)
        place = self.felt[0]
        reach = (1 + NUDGE) * float(np.abs(motion[:, place]).max()) + NUDGE
        grid = np.linspace(-reach, reach, GRID)
        probes = np.zeros((GRID, len(NODES), len(self.straight.states)))
        probes[..., place] = grid[:, None] + NODES * unsure[place]
        every = self._push(values, probes.reshape(-1, probes.shape[-1]), np.full(GRID * len(NODES), mean), mean)
        table = every.reshape(GRID, len(NODES), -1).transpose(0, 2, 1) @ (WEIGHTS / WEIGHTS.sum())
        return CubicSpline(grid, table)(motion[:, place])

    def share(self, change: np.ndarray, unsure: np.ndarray) -> float:
        """By what share the deviation (nx,) that matters changes."""
        return float(change[self.felt[0]] / unsure[self.felt[0]]) if len(self.felt) == 1 and unsure[self.felt[0]] > 0 else 0.0

    @cached_property
    def felt(self) -> list[int]:
        """The places of the states on which it depends."""
        count = len(self.straight.states)
        moved = LARGE * (1 + np.eye(count))
        return [i for i in range(count) if self._differs(self._usual, moved[i : i + 1])]

    @cached_property
    def depends_on(self) -> list[str]:
        """The parameters on which it depends."""
        motion = np.full((1, len(self.straight.states)), LARGE)
        return [n for n in self.component.values if self._differs(self._usual | {n: 1.1 * self._usual[n]}, motion)]

    def _differs(self, values: Mapping[str, float], motion: np.ndarray) -> bool:
        """Whether it is another with these values, or in this motion, by more than rounding."""
        speed = np.array([SPEED])
        usual = self._push(self._usual, np.full(motion.shape, LARGE), speed, SPEED)
        return bool(np.any(np.abs(self._push(values, motion, speed, SPEED) - usual) > ROUNDING * np.abs(usual).max()))

    @cached_property
    def _usual(self) -> dict[str, float]:
        """Values with which every effect is there."""
        return dict(self.component.values) | {n: max(row.start, row.min) or 1.0 for n, row in self.effects.items()}

    def _push(self, values: Mapping[str, float], motion: np.ndarray, speed: np.ndarray, mean: float) -> np.ndarray:
        """M^-1 f (n, nb) in a motion (n, nx) at speeds (n,), with the mass matrix of a mean speed."""
        states = dict(zip(self.straight.states, motion.T, strict=False))  # those of disturbances come last
        known = {**self.component.start_values(), **values, self.over: speed, **states}
        forces = [np.stack([np.broadcast_to(c.run(known, NUMERIC)[f"der({r})"], len(motion)) for r in self.rows]) for c in (self.component, self.straight)]
        entries = self.straight.mass_entries({**self.straight.start_values(), **values, self.over: mean}, NUMERIC)
        mass = np.array([[entries.get((a, b), float(a == b)) for b in self.rows] for a in self.rows], float)
        return np.linalg.solve(mass, forces[0] - forces[1]).T


def is_linear(stand: LinearStand, effect: type[Effect]) -> bool:
    """Whether a vehicle with an effect has the same slopes in motion as at rest."""
    component = stand.with_effects([effect])
    moved = {f"{stand.part}.{n}" if stand.part else n for e in vehicle_of(stand).elements.values() for n in (e.deflection, e.rate)}
    values = {n: max(row.start, row.min) or 1.0 for n, row in component.table.items() if row.role == "parameter" and effect.family in n}
    at_rest, in_motion = (linearise(component, **values, **dict.fromkeys(moved, size)).A for size in (0.0, LARGE))
    return bool(np.allclose(at_rest, in_motion, rtol=1e-9))


def vehicle_of(stand: LinearStand) -> Component:
    """The vehicle in a stand, alone or in a system."""
    return stand.component.parts[stand.part] if stand.part else stand.component  # type: ignore[attr-defined]
