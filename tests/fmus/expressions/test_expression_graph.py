"""Terms: SymPy operations on a term act on the expression that defines it."""

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from fmus.expressions.expression_graph import Term, common_subexpressions, term

x, y = sympy.symbols("x y", real=True)
INNER = x * y + sympy.sin(x)
OUTER = sympy.sqrt(INNER**2 + 1) * y


def of_terms():
    inner = term(INNER)
    return term(sympy.sqrt(inner**2 + 1) * y) + inner * x


@pytest.mark.slow
@given(st.floats(-3, 3), st.floats(-3, 3))
def test_slopes_are_those_of_the_expression(a, b):
    plain = OUTER + INNER * x
    for symbol in (x, y):
        for order in (1, 2):
            lines, (slope,) = common_subexpressions([of_terms().diff(symbol, order)])
            values = {x: a, y: b}
            for name, definition in lines:
                values[name] = definition.xreplace(values)
            expected = float(plain.diff(symbol, order).xreplace({x: a, y: b}))
            # Rounding of two second derivatives evaluated in different orders.
            assert float(slope.xreplace(values)) == pytest.approx(expected, rel=1e-10, abs=1e-10)


def test_a_term_depends_on_the_symbols_of_its_definition():
    assert of_terms().free_symbols == {x, y}


def test_equal_definitions_are_one_term_and_atoms_stay():
    assert term(INNER) is term(INNER)
    assert term(x) is x and term(-x) == -x and term(2.5) == 2.5


def test_replacing_a_symbol_reaches_into_terms():
    for replaced in (of_terms().subs(x, 2), of_terms().xreplace({x: sympy.Integer(2)})):
        assert replaced.free_symbols == {y}


def test_lambdified_once_per_term():
    function = sympy.lambdify([x, y], [of_terms()], "numpy", cse=common_subexpressions)
    expected = sympy.lambdify([x, y], [OUTER + INNER * x], "numpy")
    assert np.allclose(function(0.3, -1.2), expected(0.3, -1.2), rtol=1e-14)


def test_a_chain_of_terms_stays_small():
    """Twelve squarings of a sum are some 10^4 nodes as a tree, their slope some 10^8."""
    chain = x + 1
    for _ in range(12):
        chain = term(chain * chain + y)
    lines, _ = common_subexpressions([chain.diff(x)])
    assert isinstance(chain, Term) and len(lines) < 60


def test_slopes_that_are_known_are_taken():
    """A slope that is given with the term is used as it is; any other slope is derived from the definition."""
    slope = term(y + sympy.cos(x))
    known = term(INNER, (x, 0.0), (slope, 1))
    assert known.diff(x) is slope and known is not term(INNER)
    assert known.diff(y) == x and known.diff(x, 2).definition == -sympy.sin(x)
