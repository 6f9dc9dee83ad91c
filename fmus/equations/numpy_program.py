"""The equations of a component as recorded operations, evaluated with their derivatives on whole arrays.

    x' = M(p, x)^-1 f(x, u, p, t),   y = g(x, u, p, t)
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.equations.by_structure import once_per_structure
from fmus.equations.numpy_source import numpy_function
from fmus.expressions.forward_ad import Node, Recorder


@dataclass
class RecordedEquations:
    """The equations of a component as nodes; the same for all parameter values of one structure.

    rates holds f, mass the entries of M that differ from the identity, outputs g. symbols are the leaves by name.
    """

    component: Component
    recorder: Recorder
    symbols: dict[str, Node]
    rates: list[Any]
    mass: dict[tuple[str, str], Any]
    outputs: list[Any]

    @cached_property
    def explicit_rates(self) -> list[Any]:
        """M^-1 f by Gaussian elimination without pivoting: M belongs to the kinetic energy, so that no pivot
        vanishes.
        """
        names, right = self.component.states, list(self.rates)
        matrix = [[self.mass.get((r, c), float(r == c)) for c in names] for r in names]
        for k in range(len(names)):
            for i in range(len(names)):
                if i != k and matrix[i][k] != 0.0:
                    factor = matrix[i][k] / matrix[k][k]
                    matrix[i] = [a - factor * b for a, b in zip(matrix[i], matrix[k], strict=True)]
                    right[i] = right[i] - factor * right[k]
        return [r if matrix[i][i] == 1.0 else r / matrix[i][i] for i, r in enumerate(right)]

    @cached_property
    def jacobian(self) -> "Jacobian":
        """d(f - M x', g)/d(x, u); x' occurs only where M depends on x or u."""
        states, unknowns = self.component.states, self.component.states + self.component.inputs
        changing = {place: m for place, m in self.mass.items() if not depends_on(m).isdisjoint(unknowns)}
        rates = dict(zip(states, self.rates, strict=True))
        for (row, column), m in changing.items():
            rates[row] = rates[row] - m * self.recorder.leaf(f"der({column})")
        return Jacobian([*rates.values(), *self.outputs], unknowns, bool(changing))


@once_per_structure
def recorded_equations(component: Component) -> RecordedEquations:
    """The equations of the component as recorded operations.

    Raises InputError when a rate or an output is missing, or is not in the table.
    """
    recorder = Recorder()
    symbols = {n: recorder.leaf(n) for n in ("time", *component.rows("parameter", "input", "state"))}
    results = component.complete(component.run(symbols, recorder))
    mass = component.mass_entries(symbols, recorder)
    rates = [results[f"der({n})"] for n in component.states]
    return RecordedEquations(component, recorder, symbols, rates, mass, [results[n] for n in component.outputs])


class Program:
    """Nodes as a function of the values of their leaves, which is written and compiled at its first call."""

    def __init__(self, results: Sequence[Any]):
        self.results = list(results)
        found: dict[int, Node] = {}
        waiting = [r for r in self.results if isinstance(r, Node)]
        while waiting:
            node = waiting.pop()
            if node.place not in found:
                found[node.place] = node
                waiting += [a for a in node.arguments if isinstance(a, Node)]
        self.nodes = [found[place] for place in sorted(found)]  # each after its arguments
        self.leaves = [n for n in self.nodes if not n.arguments]

    @cached_property
    def function(self) -> Callable[..., tuple[Any, ...]]:
        """The function of the values of the leaves, in their order."""
        return numpy_function(self.nodes, self.results)

    def __call__(self, values: Mapping[str, Any]) -> list[Any]:
        """The results at values by name, numbers or arrays of shapes that broadcast: each a number, or an array where it
        depends on an array."""
        return list(self.function(*[values[leaf.word] for leaf in self.leaves]))


class Jacobian:
    """The derivatives of rows of equations by unknowns, as a function of values by name.

    needs_rates says whether the values must contain x', by the names `der(state)`.
    """

    def __init__(self, rows: Sequence[Any], unknowns: Sequence[str], needs_rates: bool):
        self.shape, self.needs_rates = (len(rows), len(unknowns)), needs_rates
        self.slopes = slopes_of(rows, unknowns)
        self.program = Program(list(self.slopes.values()))

    def __call__(self, values: Mapping[str, Any]) -> np.ndarray:
        """The matrix (..., rows, unknowns) at values by name, numbers or arrays of any shapes that broadcast."""
        points = np.broadcast_shapes(*(np.shape(values[leaf.word]) for leaf in self.program.leaves))
        matrix = np.zeros((*points, *self.shape))
        for (i, j), slope in zip(self.slopes, self.program(values), strict=True):
            matrix[..., i, j] = slope
        return matrix


def slopes_of(
    rows: Sequence[Any], unknowns: Sequence[str], slope: Callable[[Node, str], Any] = Node.slope
) -> dict[tuple[int, int], Any]:
    """The derivatives of rows by unknowns that are not zero, by place (row, unknown): nodes or numbers."""
    slopes = {
        (i, j): slope(row, x) for i, row in enumerate(rows) for j, x in enumerate(unknowns) if isinstance(row, Node)
    }
    return {place: s for place, s in slopes.items() if s != 0.0}


def depends_on(x: Any) -> frozenset[str]:
    """The names of the leaves that a node depends on; empty for a number."""
    return x.depends if isinstance(x, Node) else frozenset()
