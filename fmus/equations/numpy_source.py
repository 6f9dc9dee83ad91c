"""Recorded operations as the source of one Python function of numbers and NumPy arrays.

    def function(v0, v1):
        v2 = v0 * v1
        v0 = sin(v2)
        return (v0, v2)

A variable is assigned again after the last use of its value, so that few intermediate arrays exist at a time and stay
in the processor's cache. Leaves are arguments by position: no name of an equation becomes part of the source.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from fmus.expressions.derivative_rules import COMPARISONS
from fmus.expressions.forward_ad import Node

TRUTH_VALUES = (*COMPARISONS, "logical_and", "logical_or")
OPERATORS = {"multiply": "{} * {}", "reciprocal": "1.0 / {}", "power": "{} ** {}"}


def numpy_function(nodes: Sequence[Node], results: Sequence[Any]) -> Callable[..., tuple[Any, ...]]:
    """The function of the values of the leaves among `nodes`, in their order, that returns those of `results`.

    nodes are the operations that the results need, each after its arguments; results are nodes or numbers.
    """
    names = {leaf: f"v{i}" for i, leaf in enumerate(n for n in nodes if not n.arguments)}
    arguments, free, lines = ", ".join(names.values()), [], []
    uses = Counter(a for n in nodes for a in n.arguments if isinstance(a, Node))
    uses += Counter(r for r in results if isinstance(r, Node))
    operations = [n for n in nodes if n.arguments]
    for node in operations:
        expression = _expression(node, names)
        for argument in (a for a in node.arguments if isinstance(a, Node)):
            uses[argument] -= 1
            if not uses[argument]:
                free.append(names[argument])
        names[node] = free.pop() if free else f"v{len(names)}"
        lines.append(f"    {names[node]} = {expression}")
    returned = "".join(f"{_result(r, names)}, " for r in results)
    source = "\n".join([f"def function({arguments}):", *lines, f"    return ({returned})"])
    functions = {n.word: n.function() for n in operations if n.word != "sum" and n.word not in OPERATORS}
    exec(source, functions)
    return functions["function"]


def _expression(node: Node, names: Mapping[Any, str]) -> str:
    arguments = [_written(a, names) for a in node.arguments]
    if node.word == "sum":
        return _sum(arguments, *node.weights)
    if node.word in OPERATORS:
        return OPERATORS[node.word].format(*arguments)
    return f"{node.word}({', '.join(arguments)})"


def _sum(terms: Sequence[str], constant: float, *weights: float) -> str:
    """The sum of a constant and of terms with weights."""
    written = ""
    for weight, term in zip(weights, terms, strict=True):
        sign = "-" if weight < 0 else "+"
        factor = "" if abs(weight) == 1.0 else f"{_written(abs(weight), {})} * "
        written += f" {sign} {factor}{term}"
    return written.removeprefix(" + ") + (f" + {_written(constant, {})}" if constant else "")


def _result(x: Any, names: Mapping[Any, str]) -> str:
    """A result; truth values as numbers, and a leaf as a copy."""
    converted = isinstance(x, Node) and (x.word in TRUTH_VALUES or not x.arguments)
    return ("1.0 * " if converted else "") + _written(x, names)


def _written(x: Any, names: Mapping[Any, str]) -> str:
    """A node by the name of its variable, a number by its digits."""
    if isinstance(x, Node):
        return names[x]
    return f"float('{float(x)!r}')" if x != x or abs(x) == float("inf") else f"({float(x)!r})"
