"""What all models have: the base with some effects, and what a fit's vector says of their parameters.

    q = [log |base|, open and effects' parameters as they are]

A free parameter of the base keeps its sign.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmus.component import Component
from fmus.effects import Effect
from fmus.variables import Variable


class BaseAndEffects:
    """A stand's component with effects; `base`, `own`, `names`, `rows` and `sizes` as `AnyModel` has them."""

    def __init__(self, stand: Any, effects: Sequence[type[Effect]] = (), open_: Sequence[str] = ()):
        self.stand, self.effects = stand, tuple(effects)
        self.component: Component = stand.with_effects(effects)
        self.base = [f.name for f in stand.free]
        self.own = [*open_, *(stand.parameter(e, n) for e in effects for n in e.sought())]
        self.names = self.base + self.own
        shapes = {stand.parameter(e, n) for e in effects for n in e.shapes()}
        self.sizes = [i for i, n in enumerate(self.own) if n not in shapes]
        self.rows: list[Variable] = [self.component.table[n] for n in self.own]
        self.signs = np.array([np.sign(self.component.values[n]) for n in self.base])

    def unknowns(self, run: Any) -> int:
        """How many numbers of a run alone are taken out of it beside the parameters."""
        return 0

    def anew(self, run: Any) -> None:
        """What is simulated of a run next is no trial of a fit: whatever it takes may be tried, as when the run was new to the model."""

    def start(self, shapes: Mapping[str, float] | None = None) -> np.ndarray:
        """The vector of the component's own values, some of the effects' replaced."""
        values = {**self.component.values, **(shapes or {})}
        return np.array([np.log(abs(values[n])) for n in self.base] + [values[n] for n in self.own])

    def values(self, q: np.ndarray) -> dict[str, float]:
        """Parameter values by name for a vector."""
        nb = len(self.base)
        found = {**self.component.values, **dict(zip(self.base, self.signs * np.exp(q[:nb]), strict=True))}
        return found | dict(zip(self.own, q[nb:], strict=True))
