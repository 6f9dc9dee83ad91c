"""The mathematical functions of equations on SymPy symbols; see `fmus.expressions.functions` for the list.

SymPy takes 0.4 s to import, which what only computes numbers does without.
"""

from dataclasses import dataclass
from typing import Any

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


SYMBOLIC = _SymPyWords()
