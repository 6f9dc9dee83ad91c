"""Exact linearisation of a component at one point or at arrays of points (speeds, parameter values).

    x' = A x + B u,   y = C x + D u
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fmus.declaration.component import Component
from fmus.equations.numpy_program import recorded_equations
from fmus.expressions.functions import NUMERIC
from fmus.support.errors import InputError, unknown
from fmus.support.files import write_atomically


@dataclass(frozen=True, repr=False)
class StateSpace:
    """Matrices A (..., nx, nx), B (..., nx, nu), C (..., ny, nx), D (..., ny, nu) with the names of their signals, in
    SI.

    The leading axes, if any, are those of the points at which the component was linearised (speeds, parameter values).

        >>> found = mf.linearise(mf.rider("mean_2011"))
        >>> found.states, found.A.shape
        (('torso_angle', 'torso_momentum'), (2, 2))
        >>> found.frequency_response(2 * np.pi * np.array([1.0, 2.0]), "handlebar_torque", "steer_angle").shape
        (2,)
        >>> found.to_control().nstates
        2
        >>> found.save_matlab("rider.mat").name
        'rider.mat'
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def frequency_response(self, omega: np.ndarray, output: str, input: str) -> np.ndarray:
        """G(i omega) from one input to one output, complex; omega [rad/s] of any shape, the result of the same shape.

        For stacked matrices the shape of omega must broadcast with that of the points, as (100, 1) with (30,). Raises
        InputError for a name that is no output or no input.
        """
        i, j = _place("output", output, self.outputs), _place("input", input, self.inputs)
        omega = np.asarray(omega, float)
        shifted = 1j * omega[..., None, None] * np.eye(len(self.states)) - self.A
        column = np.broadcast_to(self.B[..., j, None].astype(complex), (*shifted.shape[:-1], 1))
        return (self.C[..., i, None, :] @ np.linalg.solve(shifted, column))[..., 0, 0] + self.D[..., i, j]

    def to_control(self) -> Any:
        """The same system as `control.StateSpace`, with the names of its states, inputs and outputs.

        python-control allows no dots in names: `vehicle.speed` becomes `vehicle_speed`. Raises InputError for matrices
        of more than one point.
        """
        if self.A.ndim != 2:
            raise InputError(
                f"to_control needs matrices of one point, not of {self.A.shape[:-2]}; linearise at single values"
            )
        states, inputs, outputs = (
            [name.replace(".", "_") for name in names] for names in (self.states, self.inputs, self.outputs)
        )
        return import_module("control").ss(
            self.A, self.B, self.C, self.D, states=states, inputs=inputs, outputs=outputs
        )

    def save_matlab(self, path: str | Path, points: Mapping[str, ArrayLike] | None = None) -> Path:
        """Write A, B, C, D and the names `states`, `inputs`, `outputs` (cell arrays) as a MATLAB file; its path.

        Stacked matrices become pages: A(:, :, k). points holds further arrays by name, such as the speed of each page.
        In MATLAB: `load bike.mat; sys = ss(A, B, C, D, 'StateName', states)`. Raises InputError where the file cannot
        be written.
        """
        matrices = {name: np.moveaxis(getattr(self, name), (-2, -1), (0, 1)) for name in "ABCD"}
        names = {kind: np.array(getattr(self, kind), object).reshape(-1, 1) for kind in ("states", "inputs", "outputs")}
        values = {**matrices, **names, **(points or {})}
        savemat = import_module("scipy.io").savemat  # imported on use: it takes a quarter of a second
        return write_atomically(Path(path).with_suffix(".mat"), lambda beside: savemat(beside, values))

    def __repr__(self) -> str:
        points = f"{' x '.join(map(str, self.A.shape[:-2]))} points, " if self.A.ndim > 2 else ""
        signals = f"inputs: {', '.join(self.inputs) or 'none'}; outputs: {', '.join(self.outputs) or 'none'}"
        return f"StateSpace({points}{len(self.states)} states, {signals})"


def _place(kind: str, name: str, names: Sequence[str]) -> int:
    """The index of a signal's name. Raises InputError for a name that is not there."""
    if name not in names:
        raise unknown(f"{kind} of the linear system", name, names)
    return names.index(name)


def linearise(component: Component, **at: Any) -> StateSpace:
    """The component linearised at its start values, with any of them replaced by name: numbers or arrays, in SI.

    Arrays (of speeds, of parameter values) give stacked matrices. The Jacobian is exact. Raises InputError for a name
    that the component lacks.

        >>> mf.linearise(mf.vehicle("sharp_1971"), speed=np.arange(5.0, 60.0)).A.shape
        (55, 8, 8)
    """
    values = component.start_values()
    for name in at:
        if name not in values:
            raise unknown(f"variable of {component.name}", name, values)
    values.update(at)
    form, nx = recorded_equations(component), len(component.states)
    if form.jacobian.needs_rates:
        values.update(rates_at(component, values))
    jacobian = form.jacobian(values)
    rates, outputs = jacobian[..., :nx, :], jacobian[..., nx:, :]
    # Only these rows are solved for: the others are exact.
    coupled = [i for i, state in enumerate(component.states) if any(state in place for place in form.mass)]
    if coupled:
        mass = _mass_matrix(component, values)[..., coupled, :][..., coupled]
        solved = _solve(mass, rates[..., coupled, :])
        if solved.ndim > rates.ndim:  # an array that only the mass matrix depends on
            rates = np.array(np.broadcast_to(rates, (*solved.shape[:-2], *rates.shape[-2:])))
        rates[..., coupled, :] = solved
    return StateSpace(rates[..., :nx], rates[..., nx:], outputs[..., :nx], outputs[..., nx:],
                      component.states, component.inputs, component.outputs)  # fmt: skip


def rates_at(component: Component, values: dict[str, Any]) -> dict[str, Any]:
    """The state derivatives by name, each a number, or an array where values are arrays."""
    if not any(np.ndim(value) for value in values.values()):
        state, inputs = (np.array([values[n] for n in names]) for names in (component.states, component.inputs))
        rates, _ = component.derivatives(state, inputs, values["time"])
    else:
        results = component.run(values, NUMERIC)
        rates = np.stack(np.broadcast_arrays(*(results[f"der({n})"] for n in component.states)), axis=-1)
        rates = _solve(_mass_matrix(component, values), rates[..., None])[..., 0]
    return {f"der({n})": rates[..., i] for i, n in enumerate(component.states)}


def _mass_matrix(component: Component, values: Mapping[str, Any]) -> np.ndarray:
    """The mass matrix (..., nx, nx) at values by name, numbers or arrays."""
    entries = component.mass_entries(values, NUMERIC)
    points = np.broadcast_shapes(*map(np.shape, entries.values()))
    mass = np.zeros((*points, *2 * (len(component.states),))) + np.eye(len(component.states))
    for (row, column), entry in entries.items():
        mass[..., component.states.index(row), component.states.index(column)] = entry
    return mass


def _solve(mass: np.ndarray, right: np.ndarray) -> np.ndarray:
    """mass^-1 right; one factorisation when a single mass matrix serves a stack of right-hand sides."""
    if mass.ndim == 2 and right.ndim > 2:
        columns = np.moveaxis(right, -2, 0)
        solved = np.linalg.solve(mass, columns.reshape(len(mass), -1))
        return np.moveaxis(solved.reshape(columns.shape), 0, -2)
    return np.linalg.solve(mass, right)
