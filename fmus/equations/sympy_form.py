"""The equations of a component as SymPy expressions, and their exact Jacobian.

    M(p, x) x' = f(x, u, p, t),   y = g(x, u, p, t),   J = d(f - M x', g) / d(x, u)
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import sympy
from sympy.core.relational import Relational

from fmus.declaration.component import Component
from fmus.equations.by_structure import once_per_structure
from fmus.expressions.symbolic_functions import SYMBOLIC, Quantised


@dataclass
class Symbolic:
    """The equations of a component in symbols; the same for all parameter values of one structure.

    rates (nx) is f, mass (nx, nx) is M, outputs (ny) is g, calculated holds the calculated parameters.
    """

    component: Component
    symbols: dict[str, sympy.Symbol]
    rates: list[sympy.Expr]
    mass: sympy.Matrix
    outputs: list[sympy.Expr]
    calculated: list[sympy.Expr]

    def symbols_of(self, names: tuple[str, ...]) -> list[sympy.Symbol]:
        """The symbols of these variables."""
        return [self.symbols[name] for name in names]

    @cached_property
    def derivative_symbols(self) -> list[sympy.Symbol]:
        """The symbols that stand for x' where the mass matrix depends on the state."""
        return [sympy.Symbol(f"der({n})", real=True) for n in self.component.states]

    @cached_property
    def has_mass(self) -> bool:
        """Whether the mass matrix differs from the identity."""
        return self.mass != sympy.eye(self.mass.rows)

    @cached_property
    def coupled(self) -> list[int]:
        """The indices of the states whose rows or columns of the mass matrix differ from the identity."""
        other = self.mass - sympy.eye(self.mass.rows)
        return [i for i in range(other.rows) if any(other[i, j] != 0 or other[j, i] != 0 for j in range(other.rows))]

    @cached_property
    def jacobian(self) -> sympy.Matrix:
        """d(f - M x', g)/d(x, u), shape (nx + ny, nx + nu); x' occurs only where M depends on x or u."""
        return self.slopes(self.component.states + self.component.inputs)

    def slopes(self, names: tuple[str, ...]) -> sympy.Matrix:
        """d(f - M x', g)/d(names), shape (nx + ny, len(names))."""
        unknowns = self.symbols_of(names)
        rows = list(self.rates)
        if self.mass.free_symbols & set(unknowns):
            rows = [f - r for f, r in zip(rows, self.mass * sympy.Matrix(self.derivative_symbols), strict=True)]
        rows += self.outputs
        if not rows or not unknowns:
            return sympy.zeros(len(rows), len(unknowns))
        # The derivative of a step is taken as zero everywhere.
        return sympy.Matrix(rows).jacobian(unknowns).replace(sympy.DiracDelta, lambda *_: sympy.S.Zero)

    @cached_property
    def scheduling(self) -> tuple[str, ...] | None:
        """The inputs (the speed of a motorcycle) that must be constant for the rates to be linear in all other
        variables.

        None when no such set exists: the rates are nonlinear then, or depend on time.
        """
        component = self.component
        time, states = self.symbols["time"], set(self.symbols_of(component.states))
        constant = switching(self.rates) | self.mass.free_symbols
        if constant & {time, *states} or any(time in rate.free_symbols for rate in self.rates):
            return None
        held = {n for n in component.inputs if self.symbols[n] in constant}
        while True:
            varying = self._varying(range(len(states)), held)
            # A product of a state and an input is linear once the input is constant.
            more = varying & set(component.inputs)
            if varying and not more:
                return None
            if not more:
                return tuple(n for n in component.inputs if n in held)
            held |= more

    @cached_property
    def linear_outputs(self) -> bool:
        """Whether the outputs are linear as well while the inputs in `scheduling` are constant."""
        free = {n for n in self.component.states + self.component.inputs if n not in (self.scheduling or ())}
        unsteady = {self.symbols["time"], *(self.symbols[n] for n in free)}
        rows = range(len(self.rates), self.jacobian.rows)
        linear = not self._varying(rows, set(self.scheduling or ())) and not switching(self.outputs) & unsteady
        return linear and not any(self.symbols["time"] in e.free_symbols for e in self.outputs)

    def _varying(self, rows: Iterable[int], held: set[str]) -> set[str]:
        """The free states and inputs on which the derivatives with respect to free states and inputs depend."""
        every = self.component.states + self.component.inputs
        free = [n for n in every if n not in held]
        slopes = self.jacobian.extract(list(rows), [every.index(n) for n in free]).free_symbols
        return {n for n in free if self.symbols[n] in slopes}


def switching(expressions: Iterable[sympy.Expr]) -> set[sympy.Symbol]:
    """The symbols in switching functions: the Jacobian does not contain these, because it is zero beside a step."""
    return set().union(
        *(
            jump.free_symbols
            for e in expressions
            for jump in e.atoms(Relational, sympy.sign, sympy.Heaviside, Quantised)
        )
    )


@once_per_structure
def symbolic(component: Component) -> Symbolic:
    """The equations of the component in symbols.

    Raises InputError when a rate or an output is missing, or is not in the table.
    """
    return derive(component)


def derive(component: Component) -> Symbolic:
    """The equations of the component in symbols, derived anew. Raises InputError as `symbolic` does."""
    names = ["time", *component.rows("parameter", "input", "state")]
    symbols = {n: sympy.Symbol(n, real=True) for n in names}
    results = component.complete(component.run(symbols, SYMBOLIC))
    mass = sympy.eye(len(component.states))
    for (row, column), entry in component.mass_entries(symbols, SYMBOLIC).items():
        mass[component.states.index(row), component.states.index(column)] = entry

    def expressions(keys) -> list[sympy.Expr]:
        return [sympy.sympify(results[key]) for key in keys]

    return Symbolic(
        component,
        symbols,
        expressions(f"der({n})" for n in component.states),
        mass,
        expressions(component.outputs),
        expressions(component.rows("calculated")),
    )
