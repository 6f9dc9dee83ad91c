"""A component's equations on whole recordings: rates, outputs and their slopes, each a number or an array over time.

    x' = f(x, u, p, t),   y = g(x, u, p, t),   with df/dx, df/dp, dg/dx, dg/dp
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmus.component import Component
from fmus.tape import JUMPS, Node
from fmus.traced import Program, traced


class Equations:
    """Rates and outputs of a component, with slopes by its states and by some parameters.

    linear says that they are linear in the states. The slope by the delay of an input needs that input's rate among
    the values, under the name `rate_of(input)`.
    """

    def __init__(self, component: Component, outputs: Sequence[str], parameters: Sequence[str]):
        form = traced(component)
        self.component, self.outputs, self.parameters = component, tuple(outputs), tuple(parameters)
        self.states = component.states
        self.rows = form.explicit_rates + [form.outputs[component.outputs.index(component.shown(n))] for n in self.outputs]
        unknowns = (*self.states, *self.parameters)
        late = {delay: name for name, (_, delay) in component.delays.items()}
        slopes = {(i, j): _slope(row, x, late) for i, row in enumerate(self.rows) for j, x in enumerate(unknowns) if isinstance(row, Node)}
        self.slopes = {place: s for place, s in slopes.items() if s != 0.0}
        self.program = Program([*self.rows, *self.slopes.values()])
        own = frozenset(self.states)
        bent = [s for (_, j), s in self.slopes.items() if j < len(self.states) and isinstance(s, Node)]
        jumps = [n for n in self.program.nodes if n.word in JUMPS]
        self.linear = all(own.isdisjoint(node.depends) for node in (*bent, *jumps))

    def __call__(self, values: Mapping[str, Any], n: int) -> tuple[list[Any], np.ndarray]:
        """Rates and outputs, and the matrix (nx + ny, nx + np) of their slopes; entries are numbers or arrays (n,)."""
        results = self.program(values, n)
        slopes = np.zeros((len(self.rows), len(self.states) + len(self.parameters))).astype(object)
        for place, value in zip(self.slopes, results[len(self.rows) :], strict=True):
            slopes[place] = value
        return results[: len(self.rows)], slopes


def rate_of(name: str) -> str:
    """Under which name the rate of an input that comes late is told."""
    return f"der({name})"


def _slope(row: Node, x: str, late: Mapping[str, str]) -> Any:
    """dr/dx; by the delay of an input that is dr/du times -u'."""
    slope = row.slope(x)
    return slope - row.slope(late[x]) * row.tape.leaf(rate_of(late[x])) if x in late else slope
