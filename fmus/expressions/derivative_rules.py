"""Partial derivatives of the functions of equations, by name, for forward automatic differentiation.

A rule has the recorder m, the result r and the arguments a, b; there is one for each argument.
"""

import operator
from collections.abc import Callable

import numpy as np

SLOPES: dict[str, tuple[Callable, ...]] = {
    "multiply": (lambda m, r, a, b: b, lambda m, r, a, b: a),
    "reciprocal": (lambda m, r, a: -r * r,),
    "power": (lambda m, r, a, b: b * a ** (b - 1), lambda m, r, a, b: r * m.log(a)),
    "sin": (lambda m, r, a: m.cos(a),),
    "cos": (lambda m, r, a: -m.sin(a),),
    "tan": (lambda m, r, a: 1 + r * r,),
    "asin": (lambda m, r, a: 1 / m.sqrt(1 - a * a),),
    "acos": (lambda m, r, a: -1 / m.sqrt(1 - a * a),),
    "atan": (lambda m, r, a: 1 / (1 + a * a),),
    "atan2": (lambda m, r, a, b: b / (a * a + b * b), lambda m, r, a, b: -a / (a * a + b * b)),
    "sinh": (lambda m, r, a: m.cosh(a),),
    "cosh": (lambda m, r, a: m.sinh(a),),
    "tanh": (lambda m, r, a: 1 - r * r,),
    "exp": (lambda m, r, a: r,),
    "log": (lambda m, r, a: 1 / a,),
    "sqrt": (lambda m, r, a: 0.5 / r,),
    "absolute": (lambda m, r, a: m.sign(a),),
    "quantised": (lambda m, r, a, b: 1.0, lambda m, r, a, b: 0.0),
}
COMPARISONS = ("less", "less_equal", "greater", "greater_equal")
JUMPS = ("sign", "where", "quantised", *COMPARISONS)  # functions that may be discontinuous
FLAT = ("sign", *COMPARISONS, "logical_and", "logical_or")  # piecewise constant: derivative zero
FUNCTIONS: dict[str, Callable] = {
    "multiply": operator.mul,
    "reciprocal": lambda a: 1.0 / a,
    "power": operator.pow,
    **{word: getattr(np, word) for word in FLAT},
}
