"""Forward automatic differentiation of recorded operations.

    r = f(a, b):   dr/dx = f_a da/dx + f_b db/dx

Calling `equations(v, m)` with the nodes of a Recorder records every operation as a node. Equal operations share a node
and constants are folded, so that common subexpressions are evaluated once and zero terms vanish. Sums are flat
weighted sums of other nodes: (1 + a) - a is the number 1. Recording and differentiating take milliseconds, where
symbolic algebra takes tenths of a second, which matters where many model structures are tried.

Source: Griewank, Walther, Evaluating Derivatives, 2nd ed. (2008), ch. 3.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from numbers import Number
from typing import Any

import numpy as np

from fmus.expressions.derivative_rules import FLAT, FUNCTIONS, SLOPES
from fmus.expressions.functions import NUMERIC

LARGEST_POWER = 16  # up to which integer powers are products


class Node:
    """A recorded operation: a function (`word`) applied to other nodes and numbers, or a leaf with a name."""

    __array_ufunc__ = None  # a NumPy number beside a node leaves the operation to the node
    __slots__ = ("arguments", "depends", "place", "recorder", "slopes", "weights", "word")

    def __init__(self, recorder: "Recorder", word: str, arguments: tuple, weights: tuple, depends: frozenset[str]):
        self.recorder, self.word, self.arguments, self.weights, self.depends = (
            recorder,
            word,
            arguments,
            weights,
            depends,
        )
        self.place = len(recorder.nodes)
        self.slopes: dict[str, Any] = {}

    def __repr__(self) -> str:
        return f"Node({self.word}, {self.place})"

    def __bool__(self) -> bool:
        raise TypeError("equations use m.where(condition, when_true, when_false) instead of if")

    def slope(self, leaf: str) -> Any:
        """The derivative with respect to the leaf of this name: a node or a number."""
        if leaf not in self.depends:
            return 0.0
        if leaf not in self.slopes:
            self.slopes[leaf] = self._slope(leaf)
        return self.slopes[leaf]

    def _slope(self, leaf: str) -> Any:
        if self.word == leaf and not self.arguments:
            return 1.0
        inner = [a.slope(leaf) if isinstance(a, Node) else 0.0 for a in self.arguments]
        if self.word == "sum":
            return sum((w * s for w, s in zip(self.weights[1:], inner, strict=True)), 0.0)
        if self.word == "where":
            return self.recorder.where(self.arguments[0], inner[1], inner[2])
        if self.word in FLAT:
            return 0.0
        rules = SLOPES[self.word]
        return sum(
            (
                rule(self.recorder, self, *self.arguments) * s
                for rule, s in zip(rules, inner, strict=True)
                if not _zero(s)
            ),
            0.0,
        )

    def function(self) -> Callable:
        """The function that computes it from the values of its arguments."""
        if self.word == "sum":
            return partial(_weighted, *self.weights)
        return FUNCTIONS[self.word] if self.word in FUNCTIONS else getattr(NUMERIC, self.word)

    def __add__(self, other: Any) -> Any:
        return self.recorder.added(self, other, 1.0) if _is_value(other) else NotImplemented

    def __sub__(self, other: Any) -> Any:
        return self.recorder.added(self, other, -1.0) if _is_value(other) else NotImplemented

    def __mul__(self, other: Any) -> Any:
        return self.recorder.multiplied(self, other) if _is_value(other) else NotImplemented

    def __truediv__(self, other: Any) -> Any:
        return self.recorder.multiplied(self, self.recorder.reciprocal(other)) if _is_value(other) else NotImplemented

    def __rsub__(self, other: Any) -> Any:
        return self.recorder.added(-1.0 * self, other, 1.0)

    def __rtruediv__(self, other: Any) -> Any:
        return self.recorder.multiplied(other, self.recorder.reciprocal(self))

    def __neg__(self) -> Any:
        return -1.0 * self

    def __pos__(self) -> Any:
        return self

    def __abs__(self) -> Any:
        return self.recorder.absolute(self)

    def __pow__(self, exponent: Any) -> Any:
        return self.recorder.raised(self, exponent)

    def __rpow__(self, base: float) -> Any:
        return self.recorder.exp(float(np.log(base)) * self)

    def __lt__(self, other: Any) -> Any:
        return self.recorder.less(self, other)

    def __le__(self, other: Any) -> Any:
        return self.recorder.less_equal(self, other)

    def __gt__(self, other: Any) -> Any:
        return self.recorder.greater(self, other)

    def __ge__(self, other: Any) -> Any:
        return self.recorder.greater_equal(self, other)

    def __and__(self, other: Any) -> Any:
        return self.recorder.logical_and(self, other)

    def __or__(self, other: Any) -> Any:
        return self.recorder.logical_or(self, other)

    __radd__, __rmul__, __rand__, __ror__ = __add__, __mul__, __and__, __or__


def _is_value(other: Any) -> bool:
    """Whether a node can be combined with it; a Taylor2 value handles the operation itself."""
    return isinstance(other, (Node, Number, np.generic))


class Recorder:
    """Records operations as nodes. It is the argument `m` of equations: `recorder.sin(node)` records a sine."""

    pi = np.pi

    def __init__(self) -> None:
        self.nodes: dict[tuple, Node] = {}

    def leaf(self, name: str) -> Node:
        """The node that stands for the value of this name."""
        return self._node(name, (), (), frozenset([name]))

    def __getattr__(self, word: str) -> Callable:
        if word not in SLOPES and word not in FLAT:
            raise AttributeError(f"equations may not use m.{word}; they may use {', '.join(sorted(vars(NUMERIC)))}")
        return partial(self._apply, word)

    def _apply(self, word: str, *arguments: Any) -> Any:
        if not any(isinstance(a, Node) for a in arguments):
            return (FUNCTIONS[word] if word in FUNCTIONS else getattr(NUMERIC, word))(*arguments)
        return self._node(word, arguments)

    def _node(self, word: str, arguments: tuple, weights: tuple = (), depends: frozenset[str] | None = None) -> Node:
        key = (word, tuple(a.place if isinstance(a, Node) else (a,) for a in arguments), weights)
        if key not in self.nodes:
            if depends is None:
                depends = frozenset().union(*(a.depends for a in arguments if isinstance(a, Node)))
            self.nodes[key] = Node(self, word, arguments, weights, depends)
        return self.nodes[key]

    @staticmethod
    def term(x: Any, variables: Sequence = (), slopes: Sequence = ()) -> Any:
        """The value itself, because nodes are shared anyway; known slopes are stored (see
        `fmus.expressions.expression_graph`).
        """
        for variable, slope in zip(variables, slopes, strict=True):
            if isinstance(x, Node) and isinstance(variable, Node) and not variable.arguments:
                x.slopes.setdefault(variable.word, slope)
        return x

    total = staticmethod(NUMERIC.total)

    def where(self, condition: Any, when_true: Any, when_false: Any) -> Any:
        """`when_true` where the condition holds, `when_false` elsewhere."""
        if not isinstance(condition, Node):
            return when_true if condition else when_false
        numbers = not isinstance(when_true, Node) and not isinstance(when_false, Node)
        if when_true is when_false or (numbers and when_true == when_false):
            return when_true
        return self._node("where", (condition, when_true, when_false))

    def maximum(self, a: Any, b: Any) -> Any:
        """The larger of two values."""
        return self.where(a > b, a, b)

    def minimum(self, a: Any, b: Any) -> Any:
        """The smaller of two values."""
        return self.where(a < b, a, b)

    def added(self, a: Any, b: Any, weight: float) -> Any:
        """a + weight b, as a flat sum."""
        constant, terms = _terms(a)
        more, others = _terms(b)
        terms = dict(terms)
        for node, w in others.items():
            terms[node] = terms.get(node, 0.0) + weight * w
        return self._sum(constant + weight * more, {n: w for n, w in terms.items() if w})

    def _sum(self, constant: float, terms: Mapping[Node, float]) -> Any:
        if not terms:
            return constant
        if len(terms) == 1 and not constant:
            node, weight = next(iter(terms.items()))
            if weight == 1.0:
                return node
        if len(terms) == 2:
            known = self._common_factor(*terms.items())
            if known is not None:
                return known + constant
        ordered = sorted(terms.items(), key=lambda item: item[0].place)
        return self._node("sum", tuple(n for n, _ in ordered), (constant, *(w for _, w in ordered)))

    @staticmethod
    def _common_factor(first: tuple[Node, float], second: tuple[Node, float]) -> Any:
        """c f g - c f h as a number times f, where g and h differ by a number; None otherwise."""
        (a, weight), (b, other) = first, second
        if weight != -other or a.word != "multiply" or b.word != "multiply":
            return None
        for f in a.arguments:
            if f in b.arguments:
                left, right = (x.arguments[1 - x.arguments.index(f)] for x in (a, b))
                difference = left - right
                return None if isinstance(difference, Node) else weight * difference * f
        return None

    def multiplied(self, a: Any, b: Any) -> Any:
        """a b; constant factors become weights of a sum."""
        if not isinstance(a, Node):
            a, b = b, a
        if not isinstance(b, Node):
            constant, terms = _terms(a)
            return self._sum(constant * b, {n: w * b for n, w in terms.items() if w * b})
        (a, weight), (b, other) = _drawn_out(a), _drawn_out(b)
        if (a.word == "reciprocal" and a.arguments[0] is b) or (b.word == "reciprocal" and b.arguments[0] is a):
            return weight * other
        return weight * other * self._node("multiply", (a, b) if a.place <= b.place else (b, a))

    def reciprocal(self, a: Any) -> Any:
        """1 / a."""
        if not isinstance(a, Node):
            return 1.0 / a
        return a.arguments[0] if a.word == "reciprocal" else self._node("reciprocal", (a,))

    def raised(self, a: Node, exponent: Any) -> Any:
        """a to a power; integer powers are products."""
        if isinstance(exponent, Node) or exponent != int(exponent) or abs(exponent) > LARGEST_POWER:
            return self._node("power", (a, exponent))
        result, square, left = 1.0, a, abs(int(exponent))
        while left:
            result = result * square if left % 2 else result
            square, left = square * square if left > 1 else square, left // 2
        return result if exponent >= 0 else self.reciprocal(result)


def _drawn_out(x: Node) -> tuple[Node, float]:
    """A weighted node as the node and its weight; any other node with the weight 1."""
    return (
        (x.arguments[0], x.weights[1]) if x.word == "sum" and len(x.arguments) == 1 and not x.weights[0] else (x, 1.0)
    )


def _terms(x: Any) -> tuple[float, Mapping[Node, float]]:
    """A value as a constant and a mapping from nodes to weights."""
    if not isinstance(x, Node):
        return x, {}
    return (x.weights[0], dict(zip(x.arguments, x.weights[1:], strict=True))) if x.word == "sum" else (0.0, {x: 1.0})


def _weighted(constant: float, *rest: Any) -> Any:
    """constant + sum of weights times values; rest holds the weights, then the values."""
    half = len(rest) // 2
    first, *others = zip(rest[:half], rest[half:], strict=True)
    total = first[1] if first[0] == 1.0 else first[0] * first[1]
    for weight, value in others:
        total = total + value if weight == 1.0 else total - value if weight == -1.0 else total + weight * value
    return total + constant if constant else total


def _zero(x: Any) -> bool:
    return not isinstance(x, Node) and x == 0.0
