"""A component's equations on whole recordings: rates, output and all their slopes as arrays over time, compiled once.

    x' = f(x, u, p, t),   y = g(x, u, p, t),   with df/dx, df/dp, dg/dx, dg/dp
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import sympy

from fmus.component import Component
from fmus.symbolic import symbolic
from fmus.terms import common_subexpressions


class Equations:
    """Rates and outputs of a component, with slopes by its states and by some parameters."""

    def __init__(self, component: Component, outputs: Sequence[str], parameters: Sequence[str]):
        form = symbolic(component)
        self.component, self.outputs, self.parameters = component, tuple(outputs), tuple(parameters)
        self.states = component.states
        nx = len(self.states)
        rates = sympy.Matrix(form.rates) if nx else sympy.zeros(0, 1)
        if form.has_mass:
            rates = form.mass.LUsolve(rates)
        answers = sympy.Matrix([form.outputs[component.outputs.index(n)] for n in self.outputs])
        rows = list(rates) + list(answers)
        unknowns = form.symbols_of(self.states) + form.symbols_of(self.parameters)
        slopes = [[_slope(row, x) for x in unknowns] for row in rows]
        self.where = [(i, j) for i, line in enumerate(slopes) for j, s in enumerate(line) if s != 0]
        symbols = [s for n, s in form.symbols.items() if any(row.has(s) for row in rows)]
        self.arguments = [n for n, s in form.symbols.items() if s in symbols]
        self.function = sympy.lambdify(symbols, rows + [slopes[i][j] for i, j in self.where], "numpy", cse=common_subexpressions)

    def __call__(self, values: Mapping[str, Any], n: int) -> tuple[np.ndarray, np.ndarray]:
        """Rates and outputs (nx + ny, n), and their slopes (nx + ny, nx + np, n), at n points."""
        nx, ny = len(self.states), len(self.outputs)
        results = self.function(*(values[a] for a in self.arguments))
        rows = np.empty((nx + ny, n))
        slopes = np.zeros((nx + ny, nx + len(self.parameters), n))
        for i in range(nx + ny):
            rows[i] = results[i]
        for (i, j), value in zip(self.where, results[nx + ny :], strict=True):
            slopes[i, j] = value
        return rows, slopes


def _slope(row: sympy.Expr, x: sympy.Symbol) -> sympy.Expr:
    """The derivative; that of a jump is zero beside it."""
    if not row.has(x):
        return sympy.S.Zero
    return sympy.diff(row, x).replace(sympy.DiracDelta, lambda *_: sympy.S.Zero)
