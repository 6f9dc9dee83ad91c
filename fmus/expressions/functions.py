"""The mathematical functions of equations, on numbers and arrays (NUMERIC) and on SymPy symbols (SYMBOLIC).

Equations call them as `m.sin(x)`. C code is generated from the SymPy form.

    sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt sign absolute maximum minimum pi
    where(condition, a, b)      a where the condition holds, b elsewhere
    quantised(x, step)          x rounded to a multiple of step; x for step 0
    term(x), total(values, f)   shared subexpressions and sums (see `fmus.expressions.expression_graph`)
"""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy

from fmus.expressions.expression_graph import term, totals


class Quantised(sympy.Function):
    """x rounded to a multiple of the step, as by a converter; x for step 0. The derivative is that of x."""

    nargs = 2

    def fdiff(self, argindex=1):
        """The derivative with respect to x is 1, with respect to the step 0."""
        return sympy.Integer(1 if argindex == 1 else 0)

    def _ccode(self, printer):
        x, step = (printer._print(a) for a in self.args)
        return f"(({step}) > 0 ? ({step})*floor(({x})/({step}) + 0.5) : ({x}))"

    def _numpycode(self, printer):
        x, step = (printer._print(a) for a in self.args)
        where, floor = (printer._module_format(f"numpy.{word}") for word in ("where", "floor"))
        return f"{where}(({step}) > 0, ({step})*{floor}(({x})/{where}(({step}) > 0, {step}, 1) + 0.5), {x})"


def _quantised(x, step):
    safe = np.where(step > 0, step, 1.0)
    return np.where(step > 0, step * np.floor(x / safe + 0.5), x)[()]


def _total(values, function):
    summands = [function(value) for value in values]
    return {key: sum(s[key] for s in summands) for key in summands[0]}


@dataclass(frozen=True)
class _SymPyWords:
    """SymPy's functions, and those that SymPy names differently or lacks."""

    pi: Any = sympy.pi

    def __getattr__(self, word: str) -> Any:
        return getattr(sympy, word)

    @staticmethod
    def absolute(x):
        return sympy.Abs(x)

    @staticmethod
    def where(condition, when_true, when_false):
        return sympy.Piecewise((when_true, condition), (when_false, True))

    @staticmethod
    def quantised(x, step):
        return Quantised(x, step)

    @staticmethod
    def term(x, variables=(), slopes=()):
        return term(x, variables, slopes)

    @staticmethod
    def total(values, function):
        return totals(values, function)

    @staticmethod
    def maximum(a, b):
        return sympy.Max(a, b)

    @staticmethod
    def minimum(a, b):
        return sympy.Min(a, b)


NUMERIC = SimpleNamespace(
    pi=np.pi,
    term=lambda x, variables=(), slopes=(): x,
    total=_total,
    sin=np.sin,
    cos=np.cos,
    tan=np.tan,
    asin=np.arcsin,
    acos=np.arccos,
    atan=np.arctan,
    atan2=np.arctan2,
    sinh=np.sinh,
    cosh=np.cosh,
    tanh=np.tanh,
    exp=np.exp,
    log=np.log,
    sqrt=np.sqrt,
    sign=np.sign,
    absolute=np.abs,
    where=np.where,
    quantised=_quantised,
    maximum=np.maximum,
    minimum=np.minimum,
)
SYMBOLIC = _SymPyWords()
