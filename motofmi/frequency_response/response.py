"""The frequency response of a linear component as a function of its parameters, with exact derivatives.

    G(s, p) = N(s, p) / D(s, p),   dG/dp = (dN/dp - G dD/dp) / D

N and D are the determinants of the Rosenbrock matrix and of s M - F: polynomials in s whose coefficients
SymPy derives once from the component's equations. An evaluation then takes a few small matrix products.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import sympy

from fmus.declaration.component import Component
from fmus.declaration.variables import Variable
from fmus.equations.sympy_form import symbolic
from fmus.support.errors import InputError, unknown


class Response:
    """G(i omega; p) of a component, linearised at its start values, from one input to one output.

    parameters are names of the component's table, in the order of the vectors p (np,).
    Raises InputError for a name that the component lacks.
    """

    def __init__(self, component: Component, input: str, output: str, parameters: Sequence[str]):
        for kind, name, valid in [("input", input, component.inputs), ("output", output, component.outputs),
                                  *(("parameter", p, component.values) for p in parameters)]:  # fmt: skip
            if name not in valid:
                raise unknown(f"{kind} of {component.name}", name, valid)
        self.component, self.input, self.output, self.parameters = component, input, output, tuple(parameters)

    def __getstate__(self) -> dict:
        """Without the compiled polynomials: another process derives its own."""
        return {k: v for k, v in self.__dict__.items() if k != "_polynomials"}

    @property
    def rows(self) -> list[Variable]:
        """The rows of the component's table for the parameters: units, bounds, descriptions."""
        return [self.component.table[name] for name in self.parameters]

    @property
    def values(self) -> np.ndarray:
        """The component's own values of the parameters (np,)."""
        return np.array([self.component.values[name] for name in self.parameters])

    @cached_property
    def _polynomials(self):
        """Coefficients of N and D by rising powers of s, and their derivatives, as functions of p."""
        component = self.component
        form = symbolic(component)
        nx, s = len(component.states), sympy.Symbol("s")
        fixed = {form.symbols[n]: sympy.nsimplify(v, rational=True) for n, v in component.start_values().items()
                 if n not in self.parameters}  # fmt: skip
        row, column = nx + component.outputs.index(self.output), nx + component.inputs.index(self.input)
        jacobian = form.jacobian.subs(fixed)
        pencil = s * form.mass.subs(fixed) - jacobian[:nx, :nx]
        bordered = pencil.row_join(-jacobian[:nx, column]).col_join(
            jacobian[row, :nx].row_join(jacobian[row, column : column + 1])
        )
        if jacobian.free_symbols - set(form.symbols_of(self.parameters)):
            raise InputError(f"{component.name} is not linear around its start values: no frequency response")
        symbols = form.symbols_of(self.parameters)
        polynomials = [_determinant(matrix, s) for matrix in (bordered, pencil)]
        degree = max(p.degree() for p in polynomials)
        coefficients = [[p.coeff_monomial(s**k) for k in range(degree + 1)] for p in polynomials]
        slopes = [[sympy.diff(c, q) for c in row] for row in coefficients for q in symbols]
        return degree, sympy.lambdify(symbols, [*coefficients, *slopes], "math", cse=True)

    def powers(self, omega: np.ndarray) -> np.ndarray:
        """(i omega)^k for k = 0 to the degree, shape (n, degree + 1): what evaluations at the same omega share."""
        return (1j * np.asarray(omega, float)[:, None]) ** np.arange(self._polynomials[0] + 1)

    def __call__(self, omega: np.ndarray, p: np.ndarray | None = None) -> np.ndarray:
        """G (n,) at omega (n,) [rad/s] for parameter values p (np,), the component's own where none are given."""
        return self.with_derivatives(self.powers(omega), self.values if p is None else p)[0]

    def with_derivatives(
        self, powers: np.ndarray, p: np.ndarray, inverse: bool = False
    ) -> tuple[np.ndarray, np.ndarray]:
        """G (n,) and dG/dp (np, n), or 1/G and its derivatives, for the powers of s and parameter values p (np,)."""
        rows = np.array(self._polynomials[1](*p)) @ powers.T  # N, D, dN/dp, dD/dp
        count = len(self.parameters)
        above, below, above_slope, below_slope = rows[0], rows[1], rows[2 : 2 + count], rows[2 + count :]
        if inverse:
            above, below, above_slope, below_slope = below, above, below_slope, above_slope
        value = above / below
        return value, (above_slope - value * below_slope) / below


def _determinant(matrix: sympy.Matrix, s: sympy.Symbol) -> sympy.Poly:
    return sympy.Poly(matrix.det(method="berkowitz").expand(), s)
