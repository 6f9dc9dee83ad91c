"""The exact response of a linear system to inputs that are cubic polynomials between the samples.

    x(t+h) = e^(Ah) x(t) + G0 u + G1 u' + G2 u'' + G3 u'''

The matrices e^(Ah), G0 .. G3 are blocks of one matrix exponential (Van Loan, IEEE Trans. Autom. Control 23, 1978).
The recursion x_n = d_n + Phi d_(n-1) + Phi^2 d_(n-2) + ... is summed by doubling, 1, 2, 4, 8 ... terms at a time, until
the power of Phi is negligible.
"""

import numpy as np
from scipy.linalg import expm

from fmus.linear_analysis.linearisation import StateSpace


def exact_response(
    space: StateSpace, inputs: np.ndarray, step: float, slopes: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """States (n, nx) and outputs (n, ny) from rest for inputs (n, nu) at multiples of step [s].

    slopes (n, nu) are the time derivatives of the inputs at the samples, central differences by default.
    """
    slopes = np.gradient(inputs, step, axis=0) if slopes is None else slopes
    count, nx, nu = len(inputs), len(space.states), len(space.inputs)
    blocks = np.zeros((nx + 4 * nu, nx + 4 * nu))
    blocks[:nx, : nx + nu] = np.hstack([space.A, space.B])
    blocks[nx:-nu, nx + nu :] = np.eye(3 * nu)
    transition = expm(blocks * step)[:nx]
    secant = np.diff(inputs, axis=0) / step
    first, last = slopes[:-1], slopes[1:]
    curve = (6 * secant - 4 * first - 2 * last) / step
    twist = (6 * first + 6 * last - 12 * secant) / step**2
    states = np.zeros((count, nx))
    states[1:] = np.hstack([inputs[:-1], first, curve, twist]) @ transition[:, nx:].T
    power, reach = transition[:, :nx], 1
    while reach < count and np.abs(power).max() > 1e-30:
        states[reach:] += states[:-reach] @ power.T
        power, reach = power @ power, 2 * reach
    return states, states @ space.C.T + inputs @ space.D.T
