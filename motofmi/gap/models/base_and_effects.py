"""The common part of all models: the base with some effects, and the parameter vector of a fit.

    q = [log |base|, unrestricted and effects' parameters]

A free parameter of the base keeps its sign.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.declaration.variables import Variable
from fmus.effects import Effect


class BaseAndEffects:
    """The component of an experiment with effects; `base`, `own`, `names`, `rows` and `sizes` as in `AnyModel`."""

    def __init__(self, experiment: Any, effects: Sequence[type[Effect]] = (), unrestricted: Sequence[str] = ()):
        self.experiment, self.effects = experiment, tuple(effects)
        self.component: Component = experiment.with_effects(effects)
        self.base = [f.name for f in experiment.free]
        self.own = [*unrestricted, *(experiment.parameter(e, n) for e in effects for n in e.free_parameters())]
        self.names = self.base + self.own
        shapes = {experiment.parameter(e, n) for e in effects for n in e.nonlinear_parameters()}
        self.sizes = [i for i, n in enumerate(self.own) if n not in shapes]
        self.rows: list[Variable] = [self.component.table[n] for n in self.own]
        self.signs = np.array([np.sign(self.component.values[n]) for n in self.base])

    @property
    def magnitudes(self) -> tuple[np.ndarray, np.ndarray]:
        """The least and the largest absolute value (nb,) that the declared bounds of each parameter of the base allow
        with its sign."""
        rows = [self.component.table[n] for n in self.base]
        ends = [(r.min, r.max) if s > 0 else (-r.max, -r.min) for r, s in zip(rows, self.signs, strict=True)]
        return np.array([max(low, 0.0) for low, _ in ends]), np.array([high for _, high in ends])

    def simulate_again(self, run: Any, q: np.ndarray) -> None:
        """Make the simulation of a run with q the last one, where a model has simulations."""

    def slopes(self, run: Any, q: np.ndarray, from_last: bool = False) -> np.ndarray:
        """The derivatives (m, np) of the predicted data of a run over its standard deviation."""
        del from_last
        return self.reduced(run, q)[1]  # type: ignore[attr-defined, no-any-return]  # of every model

    def unknowns(self, run: Any) -> int:
        """The number of unknowns of a single run that are eliminated besides the parameters."""
        return 0

    def start_afresh(self, run: Any) -> None:
        """Treat the next simulation of a run as the first one, in which continuation is allowed, and not
        as a trial of a fit."""

    def start(self, shapes: Mapping[str, float] | None = None) -> np.ndarray:
        """The vector of the component's values, with some values of effects replaced."""
        values = {**self.component.values, **(shapes or {})}
        return np.array([np.log(abs(values[n])) for n in self.base] + [values[n] for n in self.own])

    def values(self, q: np.ndarray) -> dict[str, float]:
        """Parameter values by name for a vector."""
        nb = len(self.base)
        found = {**self.component.values, **dict(zip(self.base, self.signs * np.exp(q[:nb]), strict=True))}
        return found | dict(zip(self.own, q[nb:], strict=True))
