"""A component on a tape: its equations recorded, and run with their slopes over whole recordings at once.

    x' = M(p, x)^-1 f(x, u, p, t),   y = g(x, u, p, t)
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fmus.component import Component
from fmus.tape import Node, Tape

BLOCK = 8192  # samples that are computed together, so that what is between stays in the processor's cache


@dataclass
class Traced:
    """The equations of a component's structure as nodes; the same for all parameter values.

    rates are f, mass holds the entries of M that are not those of the identity, outputs are g.
    """

    component: Component
    tape: Tape
    symbols: dict[str, Node]
    rates: list[Any]
    mass: dict[tuple[str, str], Any]
    outputs: list[Any]

    @cached_property
    def explicit_rates(self) -> list[Any]:
        """M^-1 f by elimination; M is that of kinetic energy, so that no pivot vanishes."""
        names, right = self.component.states, list(self.rates)
        matrix = [[self.mass.get((r, c), float(r == c)) for c in names] for r in names]
        for k in range(len(names)):
            for i in range(len(names)):
                if i != k and matrix[i][k] != 0.0:
                    factor = matrix[i][k] / matrix[k][k]
                    matrix[i] = [a - factor * b for a, b in zip(matrix[i], matrix[k], strict=True)]
                    right[i] = right[i] - factor * right[k]
        return [r if matrix[i][i] == 1.0 else r / matrix[i][i] for i, r in enumerate(right)]


_CACHE: dict[Any, Traced] = {}


def traced(component: Component) -> Traced:
    """The component's equations on a tape, recorded once for each structure.

    Raises InputError when the equations leave a rate or an output out, or return a name that the table lacks.
    """
    if component.structure not in _CACHE:
        tape = Tape()
        symbols = {n: tape.leaf(n) for n in ("time", *component.rows("parameter", "input", "state"))}
        results = component.complete(component.run(symbols, tape))
        mass = component.mass_entries(symbols, tape)
        rates = [results[f"der({n})"] for n in component.states]
        _CACHE[component.structure] = Traced(component, tape, symbols, rates, mass, [results[n] for n in component.outputs])
    return _CACHE[component.structure]


class Program:
    """Nodes as a function of the values of leaves: what does not change is computed once, the rest in blocks."""

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

    def __call__(self, values: Mapping[str, Any], n: int) -> list[Any]:
        """The results, each a number, or (n,) where it depends on one of the values that are arrays (n,)."""
        changing = {leaf.word for leaf in self.leaves if np.ndim(values[leaf.word])}
        known: dict[Any, Any] = {leaf: values[leaf.word] for leaf in self.leaves if leaf.word not in changing}
        _carry_out([s for s in self.steps if s[0].depends.isdisjoint(changing)], known)
        often = [s for s in self.steps if not s[0].depends.isdisjoint(changing)]
        moving = [leaf for leaf in self.leaves if leaf.word in changing]
        answers = [np.empty(n) if isinstance(r, Node) and not r.depends.isdisjoint(changing) else known.get(r, r) for r in self.results]
        written = [(r, a) for r, a in zip(self.results, answers, strict=True) if isinstance(r, Node) and not r.depends.isdisjoint(changing)]
        for first in range(0, n, BLOCK):
            part = slice(first, first + BLOCK)
            here = known | {leaf: values[leaf.word][part] for leaf in moving}
            _carry_out(often, here)
            for node, answer in written:
                answer[part] = here[node]
        return answers


def depends_on(x: Any) -> frozenset[str]:
    """The names of the leaves that a node depends on; of a number none."""
    return x.depends if isinstance(x, Node) else frozenset()


def _carry_out(steps: Sequence[tuple], known: dict[Any, Any]) -> None:
    for node, function, arguments in steps:
        known[node] = function(*[known[a] for a in arguments])


def _bound(node: Node) -> tuple[Callable, list[Node]]:
    """What computes a node from those of its arguments that are nodes, and these."""
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
