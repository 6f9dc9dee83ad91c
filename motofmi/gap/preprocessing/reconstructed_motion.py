"""An imposed motion reconstructed from its low harmonics, so that it can be differentiated twice.

    x(t) = Re sum_k B_k(t) e^(i k phi(t)),   B_k cubic splines in time, k = 0, 1 and further resolved orders

The splines are fitted to the measured angle; the phase is that of the command. The second derivative of the measured
angle itself would contain its noise and quantisation, which an inertia multiplies to a torque.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, CubicSpline
from scipy.sparse import csc_array, csr_array, diags_array, hstack
from scipy.sparse.linalg import SuperLU, splu

from motofmi.gap.preprocessing.excitation_phase import Phase, knots_of, window_length

ORDERS = (2, 3)  # orders of the motion that are included besides the first, where they exceed its noise
LEAD_TIME = 2.5  # s before an interval in which the motion must be accurate too: transients last into the interval
# Factor by which knots are closer outside of the intervals, where the phase of a lagging servo changes fast. With the
# knots of the intervals the spline would oscillate within them.
STEP_KNOT_FACTOR = 4
STEP_WEIGHT = 1e-4  # weight of the samples outside of the intervals in the fit; 1 within


@dataclass(frozen=True)
class ReconstructedMotion:
    """A reconstructed motion as a function of time, in the unit of the measured angle."""

    phase: CubicSpline
    orders: tuple[int, ...]
    amplitudes: BSpline  # (1 + 2 orders): order 0, then cosine and sine of each

    def __call__(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Angle, rate and acceleration (n,) at times (n,) [s]."""
        phi, w, a = (self.phase(time, d) for d in range(3))
        values, slopes, curvatures = (self.amplitudes(time, d).T for d in range(3))
        angle, rate, acceleration = values[0].copy(), slopes[0].copy(), curvatures[0].copy()
        for i, k in enumerate(self.orders):
            c, s = np.cos(k * phi), np.sin(k * phi)
            (p, q), (p1, q1), (p2, q2) = (x[1 + 2 * i : 3 + 2 * i] for x in (values, slopes, curvatures))
            angle += p * c + q * s
            u, v = p1 + k * w * q, q1 - k * w * p  # the rate is u cos + v sin
            rate += u * c + v * s
            u1, v1 = p2 + k * (a * q + w * q1), q2 - k * (a * p + w * p1)
            acceleration += (u1 + k * w * v) * c + (v1 - k * w * u) * s
        return angle, rate, acceleration


@dataclass(frozen=True)
class MotionReconstruction:
    """The least-squares problem of a reconstruction: its columns (n, m) and their factored normal equations.

    time (n,) [s], knots [s] and weights (n,) are those of the splines.
    """

    time: np.ndarray
    phase: Phase
    orders: tuple[int, ...]
    knots: np.ndarray
    basis: csr_array  # the splines (n, m / blocks)
    columns: csc_array
    weights: np.ndarray
    factored: SuperLU

    def motion(self, angle: np.ndarray) -> ReconstructedMotion:
        """The motion of a measured angle (n,) about its mean.

        The mean is the rest position of the rider, whatever the sensor offset is.
        """
        solution = self.factored.solve(self.columns.T @ (self.weights * angle))
        amplitudes = solution.reshape(1 + 2 * len(self.orders), -1).T
        amplitudes[:, 0] -= np.average(self.basis @ amplitudes[:, 0], weights=self.weights)
        return ReconstructedMotion(
            CubicSpline(self.time, self.phase.angle), self.orders, BSpline(self.knots, amplitudes, 3)
        )

    def response_variance(
        self, bases: Iterable[tuple[int, int, np.ndarray]], response: Callable[[int], np.ndarray]
    ) -> np.ndarray:
        """The variance of the response to a motion reconstructed from white noise of variance 1, in the bases.

            var = diag(S A N^-1 A' S'),   A the columns times the response at each order, N the normal equations

        bases are (first, last, (samples, k)) as of a Reduction, S in the equation; response gives the complex frequency
        response (n,) at an order, at every time.
        """
        response_columns = _columns(self.basis, self.phase.angle, self.orders, response).tocsr()
        projections = [np.ascontiguousarray(response_columns[first:last].T @ seen) for first, last, seen in bases]
        return np.concatenate([np.sum(each * self.factored.solve(each), axis=0) for each in projections])


def motion_reconstruction(
    time: np.ndarray, phase: Phase, orders: Sequence[int] = (1,), closer: np.ndarray | float = 1.0
) -> MotionReconstruction:
    """The reconstruction of motions that are measured at times (n,) [s], with the given orders of a phase.

    The distances of the knots are divided by `closer` (n,).
    """
    inside = np.zeros(len(time), bool)
    for first, last in phase.intervals:
        inside[max(first - int(LEAD_TIME / (time[1] - time[0])), 0) : last] = True
    distance = window_length(phase.frequency) / np.where(inside, closer, STEP_KNOT_FACTOR)
    knots = knots_of(time, distance, time[np.flatnonzero(np.diff(inside.astype(int))) + 1])
    basis = BSpline.design_matrix(np.clip(time, knots[0], knots[-1]), knots, 3)
    weights = np.where(inside, 1.0, STEP_WEIGHT)
    matrix = _columns(basis, phase.angle, orders)
    # A small regularisation for splines that the data do not determine.
    normal = matrix.T @ diags_array(weights) @ matrix
    normal = normal + 1e-9 * diags_array(normal.diagonal() + 1.0)
    return MotionReconstruction(time, phase, tuple(orders), knots, basis, matrix, weights, splu(normal.tocsc()))


def _columns(
    basis: csr_array, phase: np.ndarray, orders: Sequence[int], response: Callable[[int], np.ndarray] | None = None
) -> csc_array:
    """Splines, then splines times cosine and sine of each order; times the response at each order, if that is given."""
    blocks = [basis if response is None else 0 * basis]
    for k in orders:
        wave = np.exp(1j * k * phase) * (1.0 if response is None else response(k))
        blocks += [diags_array(wave.real) @ basis, diags_array(wave.imag) @ basis]
    return hstack(blocks, format="csc")
