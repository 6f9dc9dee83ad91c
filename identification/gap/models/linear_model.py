"""Base and effects linearised over an input: what models of eigenvalues and of recorded runs share.

    x' = A(V, p) x + B(V, p) u,   with dA/dp, dB/dp by central differences
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Self

import numpy as np

from fmus.effects import Effect
from fmus.linear import StateSpace, linearise
from identification.gap.models.base_and_effects import BaseAndEffects
from identification.gap.stands.linear_stand import LinearStand

NUDGE = 1e-5  # of a parameter, for a central difference: rounding and curvature then are both near 1e-10


class LinearModel(BaseAndEffects):
    """A parameter vector (np,) holds the open parameters among the effects' ones."""

    stand: LinearStand
    predicted: Any = None  # the slopes come with what they are slopes of

    def __init__(self, stand: LinearStand, effects: Sequence[type[Effect]] = ()):
        super().__init__(stand, effects, stand.open)
        self.sloped_from = 0

    def joined_by(self, *effects: type[Effect], slopes_of_base: bool = True) -> Self:
        """The model with further effects; without slopes of the base, those up to `sloped_from` may be zero."""
        joined = type(self)(self.stand, [*self.effects, *effects])
        joined.sloped_from = 0 if slopes_of_base else len(self.names)
        return joined

    def linearised(self, q: np.ndarray, at: np.ndarray) -> tuple[StateSpace, StateSpace]:
        """The state spaces at the inputs (n,), and their slopes by the vector: matrices (np, n, ...)."""
        nb, number = len(self.base), len(q)
        step = self.steps(q)
        moved = q + np.concatenate([np.zeros((1, number)), np.diag(step), -np.diag(step)])
        every: dict[str, Any] = {n: (self.signs[i] * np.exp(c) if i < nb else c)[:, None] for i, (n, c) in enumerate(zip(self.names, moved.T, strict=True))}
        space = linearise(self.component, **{**self.component.values, **every, self.stand.over: at})
        matrices = [getattr(space, name) for name in "ABCD"]
        here = dict(zip("ABCD", (m[0] for m in matrices), strict=True))
        slopes = dict(zip("ABCD", ((m[1 : number + 1] - m[number + 1 :]) / (2 * step[:, None, None, None]) for m in matrices), strict=True))
        return replace(space, **here), replace(space, **slopes)

    def steps(self, q: np.ndarray) -> np.ndarray:
        """By how much each parameter is moved (np,) for a central difference; a zero by a thousandth of its start."""
        usual = np.array([1e-3 * abs(r.start) or 1.0 for r in self.rows])
        return NUDGE * np.concatenate([np.ones(len(self.base)), np.maximum(np.abs(q[len(self.base) :]), usual)])

    def largest(self, runs: Sequence[Any]) -> float:
        """A linear model knows no amplitude."""
        del runs
        return 1.0

    def with_noise_beside(self, run: Any, q: np.ndarray) -> Any:
        """The noise is known from elsewhere."""
        del q
        return run
