"""Nonlinear forces of effects on a vehicle, in a motion that is predicted sample by sample.

    M x' = M (A x + B u) + f(x),     b(x) = M^-1 E f(x^ + sigma xi)

Where f depends on one state alone (friction on a rate), b is its expectation for a normal prediction error of standard
deviation sigma of that state: even with a small error the predicted rate differs from zero where the vehicle sticks.

Source: Gelb (ed.), Applied Optimal Estimation (1974), ch. 6.2, on statistical linearisation.
"""

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from fmus.declaration.component import Component
from fmus.declaration.variables import Variable
from fmus.effects import Effect
from fmus.expressions.functions import NUMERIC
from fmus.linear_analysis.linearisation import linearise
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.models.kalman import LinearisedForce
from motofmi.gap.preprocessing.predicted_run import PredictedRun

LARGE = 0.1  # deflection [rad] and rate [rad/s] at which a nonlinear effect's derivatives differ from those at rest
SPEED = 10.0  # m/s, at which the dependence on states and parameters is determined
ROUNDING = 1e-9  # relative change that is attributed to rounding
DIFFERENCE_STEP = 1e-6  # finite-difference step over a state's largest value
GRID = 1001  # points of the interpolation over one state
NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(9)  # of a normal distribution


class NonlinearForce:
    """The nonlinear forces of a component, as the difference to its linear part, acting on the rates of `rows`.

    over is the speed input; effects holds the declarations of the effects' parameters by name.
    """

    def __init__(self, component: Component, linear_part: Component, over: str, effects: Mapping[str, Variable]):
        self.component, self.linear_part, self.over, self.effects = component, linear_part, over, effects
        entries = linear_part.mass_entries({**linear_part.start_values(), **linear_part.values}, NUMERIC)
        self.rows = tuple(
            n for n in linear_part.states if any(n in place for place in entries)
        )  # those that the mass matrix couples

    def near(
        self, run: PredictedRun, values: Mapping[str, float], motion: np.ndarray, deviation: np.ndarray
    ) -> LinearisedForce:
        """b and its derivatives by the states about a motion (n, nx)."""
        value = self.expected(run, values, motion, deviation)
        slope = np.zeros((*value.shape, motion.shape[1]))
        for i in self.acting_states:
            step = DIFFERENCE_STEP * max(float(np.abs(motion[:, i]).max()), DIFFERENCE_STEP)
            perturbed = motion.copy()
            perturbed[:, i] += step
            slope[..., i] = (self.expected(run, values, perturbed, deviation) - value) / step
        return LinearisedForce(value - (slope @ motion[..., None])[..., 0], slope)

    def expected(
        self, run: PredictedRun, values: Mapping[str, float], motion: np.ndarray, deviation: np.ndarray
    ) -> np.ndarray:
        """b (n, nb) in a motion (n, nx) whose states have the standard deviations `deviation` (nx,)."""
        speed = run.averaged(run.recording[run.over])
        mean = float(run.speeds[0].mean())
        if len(self.acting_states) != 1:
            return self._added_rates(values, motion, speed, mean)
        place = self.acting_states[0]
        reach = (1 + DIFFERENCE_STEP) * float(np.abs(motion[:, place]).max()) + DIFFERENCE_STEP
        grid = np.linspace(-reach, reach, GRID)
        probes = np.zeros((GRID, len(NODES), len(self.linear_part.states)))
        probes[..., place] = grid[:, None] + NODES * deviation[place]
        every = self._added_rates(values, probes.reshape(-1, probes.shape[-1]), np.full(GRID * len(NODES), mean), mean)
        table = every.reshape(GRID, len(NODES), -1).transpose(0, 2, 1) @ (WEIGHTS / WEIGHTS.sum())
        return CubicSpline(grid, table)(motion[:, place])

    def share(self, change: np.ndarray, deviation: np.ndarray) -> float:
        """The relative change of the standard deviation (nx,) on which b depends."""
        return (
            float(change[self.acting_states[0]] / deviation[self.acting_states[0]])
            if len(self.acting_states) == 1 and deviation[self.acting_states[0]] > 0
            else 0.0
        )

    @cached_property
    def acting_states(self) -> list[int]:
        """The indices of the states on which b depends."""
        count = len(self.linear_part.states)
        large_motions = LARGE * (1 + np.eye(count))
        return [i for i in range(count) if self._differs(self._acting_values, large_motions[i : i + 1])]

    @cached_property
    def depends_on(self) -> list[str]:
        """The parameters on which b depends."""
        motion = np.full((1, len(self.linear_part.states)), LARGE)
        values = self._acting_values
        return [n for n in self.component.values if self._differs(values | {n: 1.1 * values[n]}, motion)]

    def _differs(self, values: Mapping[str, float], motion: np.ndarray) -> bool:
        """Whether b changes with these values, or in this motion, by more than rounding."""
        speed = np.array([SPEED])
        usual = self._added_rates(self._acting_values, np.full(motion.shape, LARGE), speed, SPEED)
        change = self._added_rates(values, motion, speed, SPEED) - usual
        return bool(np.any(np.abs(change) > ROUNDING * np.abs(usual).max()))

    @cached_property
    def _acting_values(self) -> dict[str, float]:
        """Values with which every effect acts."""
        return dict(self.component.values) | {n: max(row.start, row.min) or 1.0 for n, row in self.effects.items()}

    def _added_rates(
        self, values: Mapping[str, float], motion: np.ndarray, speed: np.ndarray, mean: float
    ) -> np.ndarray:
        """M^-1 f (n, nb) in a motion (n, nx) at speeds (n,), with the mass matrix of a mean speed."""
        states = dict(zip(self.linear_part.states, motion.T, strict=False))  # those of disturbances are last
        known = {**self.component.start_values(), **values, self.over: speed, **states}
        forces = [
            np.stack([np.broadcast_to(c.run(known, NUMERIC)[f"der({r})"], len(motion)) for r in self.rows])
            for c in (self.component, self.linear_part)
        ]
        entries = self.linear_part.mass_entries({**self.linear_part.start_values(), **values, self.over: mean}, NUMERIC)
        mass = np.array([[entries.get((a, b), float(a == b)) for b in self.rows] for a in self.rows], float)
        return np.linalg.solve(mass, forces[0] - forces[1]).T


def is_linear(experiment: VehicleOverSpeedExperiment, effect: type[Effect]) -> bool:
    """Whether a vehicle with an effect has the same state matrix at large deflections as at rest."""
    component = experiment.with_effects([effect])
    moving = {
        f"{experiment.part}.{n}" if experiment.part else n
        for e in vehicle_of(experiment).elements.values()
        for n in (e.deflection, e.rate)
    }
    values = {
        n: max(row.start, row.min) or 1.0
        for n, row in component.table.items()
        if row.role == "parameter" and effect.family in n
    }
    at_rest, large_motion = (linearise(component, **values, **dict.fromkeys(moving, size)).A for size in (0.0, LARGE))
    return bool(np.allclose(at_rest, large_motion, rtol=1e-9))


def vehicle_of(experiment: VehicleOverSpeedExperiment) -> Component:
    """The vehicle of an experiment, itself or as a part of a system."""
    return (
        experiment.component.parts[experiment.part]  # type: ignore[attr-defined]
        if experiment.part
        else experiment.component
    )
