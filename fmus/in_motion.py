"""A component made linear for motion rather than rest: what depends on the amplitude counts as it does there.

    x' = f(x),   f(x) - A x = dA x + c + what is left,   the least squares of which give dA:   A + dA instead of A = df/dx at rest

Under a sine dA is the describing function of what is not linear, under Gaussian motion the gain of statistical
linearisation: dry friction F is a damper of 4 F / (pi a) at a rate of amplitude a, of F sqrt(2 / pi) / s at one of deviation s.

Source: Gelb and Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design (1968), ch. 1.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from fmus.component import Component
from fmus.errors import unknown
from fmus.linear import StateSpace, linearise, rates_at

ALIKE = 1e-6  # of the largest: combinations of states that move by less are not told apart


def linearise_in_motion(component: Component, motion: Mapping[str, np.ndarray], **at: Any) -> StateSpace:
    """The component linearised for the motion of some of its states, (n,) points of each by name; the others rest.

    `at` are numbers or arrays as in `linearise`. Raises InputError for a name that is no state of the component.
    """
    for name in motion:
        if name not in component.states:
            raise unknown(f"state of {component.name}", name, component.states)
    rest = linearise(component, **at)
    moved = {n: np.asarray(points, float) - np.mean(points) for n, points in motion.items()}
    places = [component.states.index(n) for n in moved]
    x = np.column_stack(list(moved.values()))
    values = component.start_values() | {n: np.asarray(value)[..., None] for n, value in at.items()} | moved
    rates = np.stack(np.broadcast_arrays(*rates_at(component, values).values()), axis=-1)  # (..., n, nx)
    left = rates - x @ np.swapaxes(rest.A[..., places], -1, -2)
    size = np.sqrt(np.mean(x**2, axis=0)) + 1e-300
    slopes = np.linalg.pinv(x / size, rcond=ALIKE) / size[:, None]  # (k, n)
    A = rest.A.copy()
    A[..., places] += np.swapaxes(slopes @ (left - left.mean(axis=-2, keepdims=True)), -1, -2)
    return replace(rest, A=A)
