"""Second-order Taylor arithmetic against SymPy's derivatives."""

import numpy as np
import sympy
from hypothesis import given
from hypothesis import strategies as st

from fmus.expressions.functions import NUMERIC
from fmus.expressions.taylor2 import Taylor2, dot, rotation

p, q = sympy.symbols("p q", real=True)


def formula(cp, sp, cq, sq, m, reciprocal, root, arccosine):
    a = 2 + cp * sq - 0.3 * sp
    b = reciprocal(a) * sp + 1.5 - cq
    return dot((a, b, root(a * b + 3)), (sq, -a, b)) + arccosine(0.2 * sp * cq - 0.1)


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_six_slopes_equal_those_of_sympy(first, second):
    m = NUMERIC
    value = formula(
        *rotation(first, 1, m), *rotation(second, 2, m), m, Taylor2.reciprocal, lambda a: a.sqrt(m), lambda a: a.acos(m)
    )
    assert np.allclose(np.array(value.parts, float), EXPECTED(first, second), rtol=1e-11, atol=1e-11)  # rounding only


_EXACT = formula(sympy.cos(p), sympy.sin(p), sympy.cos(q), sympy.sin(q), sympy, lambda a: 1 / a, sympy.sqrt, sympy.acos)
EXPECTED = sympy.lambdify(
    [p, q], [_EXACT, _EXACT.diff(p), _EXACT.diff(q), _EXACT.diff(p, 2), _EXACT.diff(p, q), _EXACT.diff(q, 2)], cse=True
)
