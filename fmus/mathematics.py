"""The words that equations may use, on numbers and arrays (NUMERIC) and on SymPy symbols (SYMBOLIC).

Every word has one meaning in both; C code comes from the SymPy form. Equations call them as `m.sin(x)`.
"""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy


@dataclass(frozen=True)
class _SymPyWords:
    """SymPy's own functions, with the three that need a name of their own."""

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
    def maximum(a, b):
        return sympy.Max(a, b)

    @staticmethod
    def minimum(a, b):
        return sympy.Min(a, b)


NUMERIC = SimpleNamespace(
    pi=np.pi,
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
    maximum=np.maximum,
    minimum=np.minimum,
)
SYMBOLIC = _SymPyWords()
