"""The mathematical functions of equations on numbers and arrays; on SymPy symbols, see
`fmus.expressions.symbolic_functions`.

Equations call them as `m.sin(x)`. C code is generated from the SymPy form.

    sin cos tan asin acos atan atan2 sinh cosh tanh exp log sqrt sign absolute maximum minimum pi
    where(condition, a, b)      a where the condition holds, b elsewhere
    quantised(x, step)          x rounded to a multiple of step; x for step 0
    term(x), total(values, f)   shared subexpressions and sums (see `fmus.expressions.expression_graph`)
"""

from types import SimpleNamespace

import numpy as np


def _quantised(x, step):
    safe = np.where(step > 0, step, 1.0)
    return np.where(step > 0, step * np.floor(x / safe + 0.5), x)[()]


def _total(values, function):
    summands = [function(value) for value in values]
    return {key: sum(s[key] for s in summands) for key in summands[0]}


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
