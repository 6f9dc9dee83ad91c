"""An imposed motion rebuilt from its low harmonics, so that it can be differentiated twice.

    x(t) = Re sum_k B_k(t) e^(i k phi(t)),   B_k cubic splines in time, k = 0, 1 and what else it has

The splines are fitted to the measured angle; the phase is the command's. Differentiating the measured angle itself
would turn its noise and its converter's steps into torque.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, CubicSpline
from scipy.sparse import diags, hstack
from scipy.sparse.linalg import splu

from identification.gap.data.phase import Phase

ORDERS = (2, 3)  # looked for in the motion besides the first
KNOT = 2.5  # s between the knots of a spline: as fine as the windows of the reduction
CYCLES = 4.0


@dataclass(frozen=True)
class Rebuilt:
    """A motion that is known between the samples too."""

    phase: CubicSpline
    orders: tuple[int, ...]
    amplitudes: BSpline  # (1 + 2 orders): order 0, then cosine and sine of each

    def __call__(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Angle, rate and acceleration (n,) at times (n,) [s]."""
        phi, w, a = (self.phase(time, d) for d in range(3))
        values, slopes, bends = (self.amplitudes(time, d).T for d in range(3))
        angle, rate, acceleration = values[0].copy(), slopes[0].copy(), bends[0].copy()
        for i, k in enumerate(self.orders):
            c, s = np.cos(k * phi), np.sin(k * phi)
            (p, q), (p1, q1), (p2, q2) = (x[1 + 2 * i : 3 + 2 * i] for x in (values, slopes, bends))
            angle += p * c + q * s
            u, v = p1 + k * w * q, q1 - k * w * p  # the rate is u cos + v sin
            rate += u * c + v * s
            u1, v1 = p2 + k * (a * q + w * q1), q2 - k * (a * p + w * p1)
            acceleration += (u1 + k * w * v) * c + (v1 - k * w * u) * s
        return angle, rate, acceleration


def rebuilt(time: np.ndarray, angle: np.ndarray, phase: Phase, orders: Sequence[int] = (1,)) -> Rebuilt:
    """The motion behind a measured angle (n,) at times (n,) [s], with these orders of its phase."""
    knots = _knots(time, phase.frequency)
    basis = BSpline.design_matrix(np.clip(time, knots[0], knots[-1]), knots, 3)
    trusted = np.full(len(time), 1e-4)  # where the phase jumps, the splines need not follow
    for first, last in phase.stretches:
        trusted[max(first - int(2.5 / (time[1] - time[0])), 0) : last] = 1.0
    blocks = [basis]
    for k in orders:
        blocks += [diags(np.cos(k * phase.angle)) @ basis, diags(np.sin(k * phase.angle)) @ basis]
    matrix = hstack(blocks).tocsc()
    # A little smoothness decides what the data leave open.
    normal = matrix.T @ diags(trusted) @ matrix
    normal = normal + 1e-9 * diags(normal.diagonal() + 1.0)
    solution = splu(normal.tocsc()).solve(matrix.T @ (trusted * angle))
    return Rebuilt(CubicSpline(time, phase.angle), tuple(orders), BSpline(knots, solution.reshape(len(blocks), -1).T, 3))


def _knots(time: np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """Knots KNOT seconds apart, or CYCLES cycles where those take longer, with the ends fourfold."""
    inner, at = [], time[0]
    while True:
        f = max(float(np.interp(at, time, frequency)), 0.1)
        at += max(KNOT, CYCLES / f)
        if at > time[-1] - KNOT:
            break
        inner.append(at)
    return np.concatenate([[time[0]] * 4, inner, [time[-1]] * 4])
