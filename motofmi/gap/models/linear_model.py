"""Base and effects linearised over an input: the common part of the models of eigenvalues and of recorded runs.

    x' = A(V, p) x + B(V, p) u,   with dA/dp, dB/dp by central differences
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Self

import numpy as np

from fmus.effects import Effect
from fmus.linear_analysis.linearisation import StateSpace, linearise
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.models.base_and_effects import BaseAndEffects

DIFFERENCE_STEP = 1e-5  # relative, of the central differences: errors of rounding and curvature are both near 1e-10


class LinearModel(BaseAndEffects):
    """The parameter vector (np,) holds the unrestricted parameters before those of the effects."""

    experiment: VehicleOverSpeedExperiment
    predicted: Any = None  # derivatives are computed together with the output

    def __init__(self, experiment: VehicleOverSpeedExperiment, effects: Sequence[type[Effect]] = ()):
        super().__init__(experiment, effects, experiment.unrestricted)
        self.sloped_from = 0

    def with_added_effects(self, *effects: type[Effect], slopes_of_base: bool = True) -> Self:
        """The model with further effects; without slopes of the base, those up to `sloped_from` may be zero."""
        joined = type(self)(self.experiment, [*self.effects, *effects])
        joined.sloped_from = 0 if slopes_of_base else len(self.names)
        return joined

    def linearised(self, q: np.ndarray, at: np.ndarray) -> tuple[StateSpace, StateSpace]:
        """The state spaces at the inputs (n,), and their slopes by the vector: matrices (np, n, ...)."""
        nb, number = len(self.base), len(q)
        step = self.steps(q)
        perturbed = q + np.concatenate([np.zeros((1, number)), np.diag(step), -np.diag(step)])
        every: dict[str, Any] = {
            n: (self.signs[i] * np.exp(c) if i < nb else c)[:, None]
            for i, (n, c) in enumerate(zip(self.names, perturbed.T, strict=True))
        }
        space = linearise(self.component, **{**self.component.values, **every, self.experiment.over: at})
        shape = len(perturbed), len(at)  # less where no parameter acts on a matrix
        matrices = [np.broadcast_to(m, (*shape, *m.shape[-2:])) for m in (space.A, space.B, space.C, space.D)]
        here = dict(zip("ABCD", (m[0] for m in matrices), strict=True))
        slopes = dict(
            zip(
                "ABCD",
                ((m[1 : number + 1] - m[number + 1 :]) / (2 * step[:, None, None, None]) for m in matrices),
                strict=True,
            )
        )
        return replace(space, **here), replace(space, **slopes)

    def steps(self, q: np.ndarray) -> np.ndarray:
        """The steps (np,) of the central differences; that of a zero parameter is relative to a
        thousandth of its start."""
        usual = np.array([1e-3 * abs(r.start) or 1.0 for r in self.rows])
        own = np.maximum(np.abs(q[len(self.base) :]), usual)
        return DIFFERENCE_STEP * np.concatenate([np.ones(len(self.base)), own])

    def largest(self, runs: Sequence[Any]) -> float:
        """1, since a linear model has no amplitude."""
        del runs
        return 1.0

    def with_remaining_noise(self, run: Any, q: np.ndarray) -> Any:
        """The run itself: its noise is known from elsewhere."""
        del q
        return run
