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
from fmus.expressions.forward_ad import Node, Recorder

BLOCK = 8192  # samples per block, so that intermediate results stay in the processor's cache


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
    """Nodes compiled to a function of the values of their leaves.

    Operations on constant values are evaluated once, all others block by block along the arrays.
    """

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
        self.steps = [(n, *_bound(n)) for n in self.nodes if n.arguments]
        self.orders: dict[frozenset[str], tuple[list, list, list[bool]]] = {}  # by the leaves that are arrays

    def __call__(self, values: Mapping[str, Any], n: int) -> list[Any]:
        """The results at values by name, numbers or arrays (n,): each a number, or (n,) where it depends on an array.
        """
        changing = frozenset(leaf.word for leaf in self.leaves if getattr(values[leaf.word], "ndim", 0))
        if changing not in self.orders:
            self.orders[changing] = self._order(changing)
        once, often, arrays = self.orders[changing]
        known: dict[Any, Any] = {leaf: values[leaf.word] for leaf in self.leaves if leaf.word not in changing}
        _carry_out(once, known)
        moving = [leaf for leaf in self.leaves if leaf.word in changing]
        results = [
            np.empty(n) if is_array else known.get(r, r) for r, is_array in zip(self.results, arrays, strict=True)
        ]
        written = [(r, a) for r, a, is_array in zip(self.results, results, arrays, strict=True) if is_array]
        for first in range(0, n, BLOCK):
            part = slice(first, first + BLOCK)
            here = known | {leaf: values[leaf.word][part] for leaf in moving}
            _carry_out(often, here)
            for node, result in written:
                result[part] = here[node]
        return results

    def _order(self, changing: frozenset[str]) -> tuple[list, list, list[bool]]:
        """With these leaves as arrays: the steps that are taken once, those of each block, and which results are
        arrays."""
        once = [s for s in self.steps if s[0].depends.isdisjoint(changing)]
        often = [s for s in self.steps if not s[0].depends.isdisjoint(changing)]
        return once, often, [not depends_on(r).isdisjoint(changing) for r in self.results]


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
        used = {leaf.word: values[leaf.word] for leaf in self.program.leaves}
        points = np.broadcast_shapes(*map(np.shape, used.values()))
        count = int(np.prod(points))
        flat = {n: np.broadcast_to(x, points).ravel() if np.ndim(x) else x for n, x in used.items()}
        matrix = np.zeros((*points, *self.shape))
        for (i, j), slope in zip(self.slopes, self.program(flat, count), strict=True):
            matrix[..., i, j] = slope.reshape(points) if np.ndim(slope) else slope
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


def _carry_out(steps: Sequence[tuple], known: dict[Any, Any]) -> None:
    for node, function, arguments in steps:
        known[node] = function(*[known[a] for a in arguments])


def _bound(node: Node) -> tuple[Callable, list[Node]]:
    """The function that computes a node from its arguments that are nodes, and these arguments."""
    function, arguments = node.function(), node.arguments
    places = [i for i, a in enumerate(arguments) if isinstance(a, Node)]
    if len(places) == len(arguments):
        return function, list(arguments)

    def filled(*values: Any) -> Any:
        every = list(arguments)
        for i, value in zip(places, values, strict=True):
            every[i] = value
        return function(*every)

    return filled, [arguments[i] for i in places]
