"""Equations on a recorder: values as NumPy gives them, slopes as symbolic algebra and complex steps give them."""

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from fmus.equations.numpy_program import Program, depends_on, recorded_equations
from fmus.equations.sympy_form import symbolic
from fmus.expressions.forward_ad import Node, Recorder
from fmus.support.errors import InputError
from motofmi.workflows.gap.rig import rig_effects, rig_experiment
from rider_fmu import PassiveRider, riders
from vehicle_fmu import motorcycles

RIG = rig_experiment({})

SMOOTH = {
    "products": lambda x, y, m: (x + 2) * y - x / (3 + y) + 4,
    "powers": lambda x, y, m: x**3 - (2 + y) ** -2 + (2 + x) ** 0.5 + (2 + x) ** (y + 1) + 2**x,
    "waves": lambda x, y, m: m.sin(x) * m.cos(y) + m.tan(x * y) + m.sinh(x) / m.cosh(y) + m.tanh(x - y),
    "arcs": lambda x, y, m: m.asin(x / 2) + m.acos(y / 2) + m.atan(x * y),
    "growth": lambda x, y, m: m.exp(x * y) + m.log(3 + x) + m.sqrt(4 + y),
}


def recorded(law):
    recorder = Recorder()
    return recorder, law(recorder.leaf("x"), recorder.leaf("y"), recorder)


@pytest.mark.slow
@pytest.mark.parametrize("law", SMOOTH.values(), ids=SMOOTH)
@given(x=st.floats(-1, 1), y=st.floats(-1, 1))
def test_slopes_are_those_of_complex_steps(law, x, y):
    """Im f(x + i h) / h is exact to rounding: Squire, Trapp, SIAM Review 40 (1998) 110-112."""
    _, node = recorded(law)
    value, *slopes = Program([node, node.slope("x"), node.slope("y")])({"x": x, "y": y})

    class Complex:
        def __getattr__(self, word):
            return getattr(np, {"asin": "arcsin", "acos": "arccos", "atan": "arctan"}.get(word, word))

    exact = [law(x + 1e-30j, complex(y), Complex()).imag / 1e-30, law(complex(x), y + 1e-30j, Complex()).imag / 1e-30]
    assert value == pytest.approx(law(complex(x), complex(y), Complex()).real, rel=1e-12, abs=1e-12)
    np.testing.assert_allclose(slopes, exact, rtol=1e-10, atol=1e-12)  # a handful of roundings


@given(x=st.floats(-3, 3), y=st.floats(-3, 3))
def test_words_that_jump_have_the_slope_beside_the_jump(x, y):
    _, node = recorded(
        lambda a, b, m: (
            m.where(a > b, 2 * a, 5 * b)
            + m.absolute(a)
            + m.maximum(a, b)
            + m.minimum(3 * a, b)
            + m.sign(b)
            + m.quantised(a, 0.25)
        )
    )
    slope = Program([node.slope("x")])({"x": x, "y": y})[0]
    assert slope == (2 if x > y else 0) + np.sign(x) + (x > y) + 3 * (3 * x < y) + 1


def test_what_is_there_already_is_used_again_and_what_cancels_is_a_number():
    recorder = Recorder()
    x, y = recorder.leaf("x"), recorder.leaf("y")
    assert recorder.sin(x) * y is y * recorder.sin(x)
    assert (1 + x) - x == 1.0
    assert 0.0 * x == 0.0
    assert x / x == 1.0
    assert (1 + x) / y - x / y is 1 / y
    assert recorder.where(x > y, 2.0, 2.0) == 2.0
    assert depends_on(x * y - y * x) == frozenset()


def test_a_decision_by_if_and_an_unknown_word_are_refused():
    recorder = Recorder()
    with pytest.raises(TypeError, match="where"):
        bool(recorder.leaf("x") > 1)
    with pytest.raises(AttributeError, match=r"m\.bessel"):
        recorder.bessel(recorder.leaf("x"))


@pytest.mark.slow
@pytest.mark.parametrize("component", [
    PassiveRider(),
    *(RIG.with_effects([effect]) for effect in rig_effects() if effect.form in ("coulomb", "iwan", "head", "gap", "spring", "cubic")),
], ids=lambda c: f"{c.name}-{'-'.join(c.table)[-30:]}")  # fmt: skip
def test_rates_outputs_and_slopes_of_components_are_the_symbolic_ones(component):
    form, rng = symbolic(component), np.random.default_rng(3)
    values = component.start_values() | {
        n: float(x) for n, x in zip(component.states + component.inputs, rng.uniform(0.05, 0.2, 99), strict=False)
    }
    held = {s: values[n] for n, s in form.symbols.items()}
    recorder = recorded_equations(component)
    rates = form.mass.LUsolve(sympy.Matrix(form.rates)) if form.has_mass else sympy.Matrix(form.rates)
    rows = [*rates, *form.outputs]
    nodes = [*recorder.explicit_rates, *recorder.outputs]
    unknowns = [*component.states, *list(component.values)[:6]]
    ours = Program([*nodes, *(x.slope(n) if isinstance(x, Node) else 0.0 for x in nodes for n in unknowns)])(values)
    exact = [float(r.subs(held)) for r in rows] + [
        float(r.diff(form.symbols[n]).subs(held)) for r in rows for n in unknowns
    ]
    np.testing.assert_allclose(ours, exact, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    "component",
    [motorcycles.load("sharp_1971"), riders.load("mean_2011"), motorcycles.load("benchmark_bicycle")],
    ids=lambda c: c.name,
)
def test_rates_behind_a_mass_matrix_are_those_of_a_linear_solve(component):
    rng, form = np.random.default_rng(4), recorded_equations(component)
    state, inputs = rng.uniform(-0.1, 0.1, len(component.states)), rng.uniform(1, 2, len(component.inputs))
    values = component.start_values() | dict(zip(component.states + component.inputs, [*state, *inputs], strict=True))
    expected = np.concatenate(component.derivatives(state, inputs))
    # Elimination without a search for pivots loses two or three digits of sixteen on a mass matrix.
    np.testing.assert_allclose(
        Program([*form.explicit_rates, *form.outputs])(values), expected, rtol=1e-10, atol=1e-9
    )


def test_an_effect_at_what_is_not_there_is_refused():
    class Elsewhere(PassiveRider):
        def equations(self, v, m):
            return {n: x for n, x in super().equations(v, m).items() if n != "torso_rate"}

    with pytest.raises(InputError, match="torso_rate"):
        recorded_equations(Elsewhere())
