"""A component's equations on whole recordings: rates, outputs and their slopes, each a number or an array over time.

What a simulation needs at every step, and what only the slopes by parameters need, are computed apart.

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
        late = {delay: name for name, (_, delay) in component.delays.items()}
        self.by_state, self.by_parameter = (_slopes(self.rows, unknowns, late) for unknowns in (self.states, self.parameters))
        self.program = Program([*self.rows, *self.by_state.values()])
        self.of_parameters = Program(list(self.by_parameter.values()))
        own = frozenset(self.states)
        bent = [s for s in self.by_state.values() if isinstance(s, Node)]
        jumps = [n for n in (*self.program.nodes, *self.of_parameters.nodes) if n.word in JUMPS]
        self.linear = all(own.isdisjoint(node.depends) for node in (*bent, *jumps))

    def __call__(self, values: Mapping[str, Any], n: int) -> tuple[list[Any], np.ndarray]:
        """Rates and outputs, and the matrix (nx + ny, nx) of their slopes by the states; entries are numbers or arrays (n,)."""
        results = self.program(values, n)
        return results[: len(self.rows)], self._matrix(self.by_state, results[len(self.rows) :], len(self.states))

    def slopes(self, values: Mapping[str, Any], n: int) -> np.ndarray:
        """The matrix (nx + ny, np) of the slopes of rates and outputs by the parameters; entries are numbers or arrays (n,)."""
        return self._matrix(self.by_parameter, self.of_parameters(values, n), len(self.parameters))

    def _matrix(self, places: Mapping[tuple[int, int], Any], found: Sequence[Any], columns: int) -> np.ndarray:
        matrix = np.zeros((len(self.rows), columns)).astype(object)
        for place, value in zip(places, found, strict=True):
            matrix[place] = value
        return matrix


def rate_of(name: str) -> str:
    """Under which name the rate of an input that comes late is told."""
    return f"der({name})"


def _slopes(rows: Sequence[Any], unknowns: Sequence[str], late: Mapping[str, str]) -> dict[tuple[int, int], Any]:
    """The slopes of rows by unknowns that are not zero, by place."""
    slopes = {(i, j): _slope(row, x, late) for i, row in enumerate(rows) for j, x in enumerate(unknowns) if isinstance(row, Node)}
    return {place: s for place, s in slopes.items() if s != 0.0}


def _slope(row: Node, x: str, late: Mapping[str, str]) -> Any:
    """dr/dx; by the delay of an input that is dr/du times -u'."""
    slope = row.slope(x)
    return slope - row.slope(late[x]) * row.tape.leaf(rate_of(late[x])) if x in late else slope
