"""Second-order Taylor arithmetic against SymPy's derivatives."""

from functools import cache

import numpy as np
import pytest
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


@cache
def expected():
    """Value, first and second derivatives of the formula as a function of p and q."""
    exact = formula(
        sympy.cos(p), sympy.sin(p), sympy.cos(q), sympy.sin(q), sympy, lambda a: 1 / a, sympy.sqrt, sympy.acos
    )
    first = [exact.diff(p), exact.diff(q)]
    second = [exact.diff(p, 2), exact.diff(p, q), exact.diff(q, 2)]
    return sympy.lambdify([p, q], [exact, *first, *second], cse=True)


@pytest.mark.slow
@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_six_slopes_equal_those_of_sympy(first, second):
    m = NUMERIC
    value = formula(
        *rotation(first, 1, m), *rotation(second, 2, m), m, Taylor2.reciprocal, lambda a: a.sqrt(m), lambda a: a.acos(m)
    )
    assert np.allclose(np.array(value.parts, float), expected()(first, second), rtol=1e-11, atol=1e-11)  # rounding only
