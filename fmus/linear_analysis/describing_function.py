"""Describing-function linearisation: a component linearised about a given motion instead of about rest.

    x' = f(x),   A = df/dx at rest,   f(x) - A x = dA x + c + residual,   dA by least squares over the motion

The linear system has the matrix A + dA.

For a sinusoidal motion dA is the describing function of the nonlinear part, for Gaussian motion the gain of
statistical linearisation: dry friction F is a damper of 4 F / (pi a) at a rate of amplitude a, and of F sqrt(2 / pi) /
s at a rate with the standard deviation s.

Source: Gelb and Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design (1968), ch. 1.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.linear_analysis.linearisation import linearise, rates_at
from fmus.support.errors import unknown

ALIKE = 1e-6  # relative cutoff of singular values: combinations of states that move by less are not separated


def change_by_motion(component: Component, motion: Mapping[str, np.ndarray], **at: Any) -> np.ndarray:
    """The change dA (..., nx, nx) of the linearisation at rest by the motion of some states, (n,) points of each by name;
    the others are at rest.

    `at` are numbers or arrays as in `linearise`. The change is the same for all speeds of a vehicle where the nonlinear
    part is that of a device at its handlebar. Raises InputError for a name that is no state of the component.

        phase = np.linspace(0, 2 * np.pi, 64, endpoint=False)
        motion = {"vehicle.steer_rate": 0.5 * np.cos(phase)}
        linearise(system, **at).A + change_by_motion(system, motion, **at)
    """
    for name in motion:
        if name not in component.states:
            raise unknown(f"state of {component.name}", name, component.states)
    rest = linearise(component, **at)
    deviations = {n: np.asarray(points, float) - np.mean(points) for n, points in motion.items()}
    places = [component.states.index(n) for n in deviations]
    x = np.column_stack(list(deviations.values()))
    values = component.start_values() | {n: np.asarray(value)[..., None] for n, value in at.items()} | deviations
    rates = np.stack(np.broadcast_arrays(*rates_at(component, values).values()), axis=-1)  # (..., n, nx)
    nonlinear = rates - x @ np.swapaxes(rest.A[..., places], -1, -2)
    size = np.sqrt(np.mean(x**2, axis=0)) + 1e-300
    slopes = np.linalg.pinv(x / size, rcond=ALIKE) / size[:, None]  # (k, n)
    change = np.zeros_like(rest.A)
    change[..., places] = np.swapaxes(slopes @ (nonlinear - nonlinear.mean(axis=-2, keepdims=True)), -1, -2)
    return change
