"""The source of recorded operations gives the values that NumPy gives for the same expressions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.equations.numpy_program import Program
from fmus.expressions.forward_ad import Recorder
from fmus.expressions.functions import NUMERIC

TIME = np.linspace(-2.0, 2.0, 41)


def several(x, y, m):
    """Values that are used again, and in another order than they were recorded."""
    sine, product = m.sin(x), x * y
    square = product * product
    return [sine + square / (1 + square) - 2 * x, m.where(x > y, sine, square), square, m.exp(-square) * sine, x**3 - y]


@given(y=st.floats(-3, 3))
def test_values_are_those_of_the_expression(y):
    recorder = Recorder()
    found = Program(several(recorder.leaf("x"), recorder.leaf("y"), recorder))({"x": TIME, "y": y})
    for ours, expected in zip(found, several(TIME, y, NUMERIC), strict=True):
        np.testing.assert_allclose(ours, expected, rtol=1e-14, atol=1e-14)  # sums are in another order


def test_what_does_not_depend_on_an_array_is_a_number():
    recorder = Recorder()
    x, y = recorder.leaf("x"), recorder.leaf("y")
    moving, still, constant = Program([recorder.exp(y) * x + 1, recorder.exp(y), 2.5])({"x": TIME, "y": 0.5})
    np.testing.assert_array_equal(moving, np.exp(0.5) * TIME + 1)
    assert (still, constant) == (np.exp(0.5), 2.5)


def test_a_result_that_is_a_leaf_can_be_changed_without_the_given_array():
    given = TIME.copy()
    (result,) = Program([Recorder().leaf("x")])({"x": given})
    result[:] = 0.0
    np.testing.assert_array_equal(given, TIME)


def test_truth_values_are_numbers():
    recorder = Recorder()
    (result,) = Program([recorder.leaf("x") > 0.5])({"x": TIME})
    assert result.dtype == float and set(result) == {0.0, 1.0}


@pytest.mark.parametrize("number", [np.inf, -np.inf, -0.1, np.float64(1 / 3), 3])
def test_numbers_are_exact(number):
    recorder = Recorder()
    (chosen,) = Program([recorder.where(recorder.leaf("x") > 0, number, 1.0)])({"x": TIME})
    assert chosen[-1] == number
