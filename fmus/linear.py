"""A component linearised, exactly, for one point or for arrays of points (of speeds, of parameters) at once.

    x' = A x + B u,   y = C x + D u
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fmus.component import Component
from fmus.errors import unknown
from fmus.mathematics import NUMERIC
from fmus.symbolic import symbolic


@dataclass(frozen=True)
class StateSpace:
    """Matrices A (..., nx, nx), B (..., nx, nu), C (..., ny, nx), D (..., ny, nu) with the names of their signals."""

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def frequency_response(self, omega: np.ndarray, output: str, input: str) -> np.ndarray:
        """G(i omega) from one input to one output; omega in rad/s, any shape; complex, of the same shape."""
        i, j = self.outputs.index(output), self.inputs.index(input)
        omega = np.asarray(omega, float)
        shifted = 1j * omega[..., None, None] * np.eye(len(self.states)) - self.A
        column = np.broadcast_to(self.B[:, j, None].astype(complex), (*shifted.shape[:-1], 1))
        return (self.C[i] @ np.linalg.solve(shifted, column))[..., 0] + self.D[i, j]


def linearise(component: Component, **at: Any) -> StateSpace:
    """The component linearised at its start values, with any of them replaced by name: numbers or arrays.

    Arrays (of speeds, say) give stacked matrices. Raises InputError for a name that the component lacks.
    """
    values = component.start_values()
    for name in at:
        if name not in values:
            raise unknown(f"variable of {component.name}", name, values)
    values.update(at)
    form = symbolic(component)
    nx = len(component.states)
    if form.needs_derivatives:
        values.update(rates_at(component, values))
    jacobian = form.jacobian_entries(values)
    rates, outputs = jacobian[..., :nx, :], jacobian[..., nx:, :]
    if form.coupled:
        rates[..., form.coupled, :] = _solve(form.mass_entries(values)[..., form.coupled, :][..., form.coupled], rates[..., form.coupled, :])
    return StateSpace(rates[..., :nx], rates[..., nx:], outputs[..., :nx], outputs[..., nx:],
                      component.states, component.inputs, component.outputs)  # fmt: skip


def rates_at(component: Component, values: dict[str, Any]) -> dict[str, Any]:
    """The state derivatives by name, each a number, or an array where values are arrays."""
    if not any(np.ndim(value) for value in values.values()):
        state, told = (np.array([values[n] for n in names]) for names in (component.states, component.inputs))
        rates, _ = component.derivatives(state, told, values["time"])
    else:
        results, entries = component.run(values, NUMERIC), component.mass_entries(values, NUMERIC)
        rates = np.stack(np.broadcast_arrays(*(results[f"der({n})"] for n in component.states)), axis=-1)
        mass = np.zeros((*np.broadcast_shapes(*map(np.shape, entries.values())), *2 * (len(component.states),))) + np.eye(len(component.states))
        for (row, column), entry in entries.items():
            mass[..., component.states.index(row), component.states.index(column)] = entry
        rates = _solve(mass, rates[..., None])[..., 0]
    return {f"der({n})": rates[..., i] for i, n in enumerate(component.states)}


def _solve(mass: np.ndarray, right: np.ndarray) -> np.ndarray:
    """mass^-1 right; one factorisation when a single mass matrix serves a stack of right-hand sides."""
    if mass.ndim == 2 and right.ndim > 2:
        columns = np.moveaxis(right, -2, 0)
        solved = np.linalg.solve(mass, columns.reshape(len(mass), -1))
        return np.moveaxis(solved.reshape(columns.shape), 0, -2)
    return np.linalg.solve(mass, right)
