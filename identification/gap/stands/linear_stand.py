"""A component that is seen through its linearisation over an input (a vehicle over its speed), and what is free in it.

    x' = A(V, p) x + B(V, p) u

Effects join one part of a system, or the component itself.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from fmus.component import Component
from fmus.effects import Effect
from fmus.linear import StateSpace, linearise
from fmus.system import System
from fmus.variables import Variable
from identification.gap.stands.test_stand import Free

NUDGE = 1e-5  # of a parameter, for a central difference: rounding and curvature then are both near 1e-10


@dataclass(frozen=True)
class LinearStand:
    """A component, the part of it that effects join ("" for itself), the input over which it is seen, its free parameters.

    free are those that keep their sign, open those that may be any number, with measured_effects for what is known of
    these (value and error). exact_delays makes of what lags an input, for recorded runs.
    """

    component: Component
    part: str
    over: str
    free: tuple[Free, ...] = ()
    open: tuple[str, ...] = ()
    measured_effects: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    exact_delays: bool = False

    def with_effects(self, effects: Sequence[type[Effect]]) -> Component:
        """The component with effects."""
        inner = self.component
        joined = [e(exact_delays=self.exact_delays) for e in effects]
        if not joined:
            return inner
        if not isinstance(inner, System):
            return inner.with_effects(*joined)
        parts = {n: p.with_effects(*joined) if n == self.part else p for n, p in inner.parts.items()}
        return System(inner.name, parts, inner.wiring, inner.bindings, inner.source)

    def parameter(self, effect: type[Effect], name: str) -> str:
        """The name of an effect's parameter in the component."""
        return f"{self.part}.{effect.family}.{name}" if self.part else f"{effect.family}.{name}"


class LinearModel:
    """Base and effects as a fit sees them, linearised: what models of eigenvalues and of recorded runs share.

    A parameter vector (np,) is [log of the free base parameters, the open ones and the effects' parameters as they are].
    """

    predicted: Any = None  # the slopes come with what they are slopes of

    def __init__(self, stand: LinearStand, effects: Sequence[type[Effect]] = ()):
        self.stand, self.effects = stand, tuple(effects)
        self.component = stand.with_effects(effects)
        self.base = [f.name for f in stand.free]
        self.own = [*stand.open, *(stand.parameter(e, n) for e in effects for n in e.parameters() if n not in e.given)]
        self.names = self.base + self.own
        shapes = {stand.parameter(e, n) for e in effects for n in e.shapes()}
        self.sizes = [i for i, n in enumerate(self.own) if n not in shapes]
        self.sloped_from = 0
        self.rows: list[Variable] = [self.component.table[n] for n in self.own]

    def joined_by(self, *effects: type[Effect], slopes_of_base: bool = True) -> Self:
        """The model with further effects; without slopes of the base, those up to `sloped_from` may be zero."""
        joined = type(self)(self.stand, [*self.effects, *effects])
        joined.sloped_from = 0 if slopes_of_base else len(self.names)
        return joined

    def start(self, shapes: Mapping[str, float] | None = None) -> np.ndarray:
        """The vector of the component's own values, some of the effects' replaced."""
        values = {**self.component.values, **(shapes or {})}
        return np.array([np.log(values[n]) for n in self.base] + [values[n] for n in self.own])

    def values(self, q: np.ndarray) -> dict[str, float]:
        """Parameter values by name for a vector."""
        nb = len(self.base)
        return {**self.component.values, **dict(zip(self.base, np.exp(q[:nb]), strict=True)), **dict(zip(self.own, q[nb:], strict=True))}

    def linearised(self, q: np.ndarray, at: np.ndarray) -> tuple[StateSpace, StateSpace]:
        """The state spaces at the inputs (n,), and their slopes by the vector: matrices (np, n, ...)."""
        nb, number = len(self.base), len(q)
        step = self.steps(q)
        moved = q + np.concatenate([np.zeros((1, number)), np.diag(step), -np.diag(step)])
        every: dict[str, Any] = {n: (np.exp(c) if i < nb else c)[:, None] for i, (n, c) in enumerate(zip(self.names, moved.T, strict=True))}
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
