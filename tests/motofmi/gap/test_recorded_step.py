"""A recorded step is that of its formula in dense matrices."""

import numpy as np
import pytest

from fmus import Component, parameter, state
from motofmi.gap.models.collocation import Motion
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.implicit_formulas import HERMITE_SIMPSON, RADAU
from motofmi.gap.models.recorded_step import STEP, RecordedStep, named
from motofmi.gap.models.simulation import simulate

NX, NP, STEPS, H = 3, 2, 5, 0.3
FIXED = {(0, 0): 0.0, (0, 1): 1.0, (2, 0): -0.5}  # entries of df/dx that are constant
RNG = np.random.default_rng(5)


def entries(matrix, fixed):
    """A matrix (steps, rows, columns) as entries; those in `fixed` are numbers, and one is the same at all steps."""
    places = {(i, j): matrix[:, i, j] for i in range(matrix.shape[1]) for j in range(matrix.shape[2])}
    return places | fixed


def dense(found, rows, columns):
    matrix = np.zeros((STEPS, rows, columns))
    for (i, j), x in found.items():
        matrix[:, i, j] = x
    return matrix


def random(rows, columns, fixed=None):
    matrix = RNG.uniform(-1, 1, (STEPS, rows, columns))
    for (i, j), x in (fixed or {}).items():
        matrix[:, i, j] = x
    return matrix


@pytest.mark.parametrize("formula", [HERMITE_SIMPSON, RADAU], ids=["hermite_simpson", "radau"])
def test_step_and_forcing_are_those_of_the_formula(formula):
    (a, b, p, q), (u, v, w), s, unit = formula.inner, formula.step, H / formula.divisor, np.eye(NX)
    x1, x2, f1, f2, fm = (random(NX, 1) for _ in range(5))
    A1, A2, M = (random(NX, NX, FIXED) for _ in range(3))
    P1, P2, Q = (random(NX, NP, {(0, 0): 0.0, (0, 1): 0.0}) for _ in range(3))
    pattern = tuple(((i, j), FIXED.get((i, j))) for i in range(NX) for j in range(NX))
    by_parameter = tuple(((i, j), None if i else 0.0) for i in range(NX) for j in range(NP))
    step = RecordedStep(formula, NX, tuple(((i, 0), None) for i in range(NX)), pattern)
    matrices = {"x1": x1, "x2": x2, "f1": f1, "f2": f2, "fm": fm}
    values = {STEP: H}
    for kind, matrix in matrices.items():
        values |= named(kind, entries(matrix, {}))
    for kind, matrix in {"A1": A1, "A2": A2, "M": M}.items():
        values |= named(kind, entries(matrix, FIXED))

    inner = a * x1 + b * x2 + H * (p * f1 + q * f2)
    np.testing.assert_allclose(dense(step.inner(values), NX, 1), inner, rtol=1e-13)
    defect = x2 - x1 - s * (u * f1 + v * fm + w * f2)
    before = unit + s * (u * A1 + v * M @ (a * unit + H * p * A1))
    after = unit - s * (w * A2 + v * M @ (b * unit + H * q * A2))
    residual, correction, transition, solved = step.newton(values)
    np.testing.assert_allclose(dense(residual, NX, 1), defect, rtol=1e-13)
    tolerance = {"rtol": 1e-11, "atol": 1e-12}  # elimination without pivots near the identity loses a few digits
    np.testing.assert_allclose(dense(correction, NX, 1), -np.linalg.solve(after, defect), **tolerance)
    np.testing.assert_allclose(dense(transition, NX, NX), np.linalg.solve(after, before), **tolerance)
    np.testing.assert_allclose(dense(solved, NX, NX), np.linalg.inv(after), **tolerance)

    values |= named("inverse", solved)
    for kind, matrix in {"P1": P1, "P2": P2, "Q": Q}.items():
        values |= named(kind, entries(matrix, {}))
    forcing = s * (u * P1 + w * P2 + v * (Q + H * M @ (p * P1 + q * P2)))
    found = dense(step.forced(by_parameter, values), NX, NP)
    np.testing.assert_allclose(found, np.linalg.solve(after, forcing), **tolerance)


class Decay(Component):
    """Its parameters have the names of the formulas."""

    h = parameter("1/s", "Rate of decay", min=0, start=0.7)
    x1 = state("1", "Level", start=2.0, exposed=True)

    def equations(self, v, m):
        return {"der(x1)": -v.h * v.x1}


def test_names_of_a_component_are_apart_from_those_of_the_formulas():
    time, decay = np.linspace(0, 3, 61), Decay()
    motion = Motion(time, {}, {})
    found = simulate(Equations(decay, ["x1"], ["h"]), decay.start_values(), motion, initial=np.array([2.0]))
    exact = 2.0 * np.exp(-0.7 * time)
    np.testing.assert_allclose(found.states[:, 0], exact, rtol=1e-6)  # order 4: (0.7 * 0.05)^4 = 1.5e-6
    np.testing.assert_allclose(found.slopes[:, 0, 0], -time * exact, atol=1e-5)
