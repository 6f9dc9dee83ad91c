"""The unknowns of one segment, its initial states and sensor offsets, eliminated from its residuals.

    r - T (T' r),   dm/dq - T (T' dm/dq)

r are the residuals over the noise, and T is an orthonormal basis of their derivatives by the unknowns (variable
projection). An initial state of an effect that is bounded by the effect's equations has a normal prior of mean zero.
Such states b are eliminated by their joint distribution with the data,

    (1 + B s s' B')^(-1/2) r = r - U f (U' r),   f = 1 - (1 + S^2)^(-1/2)

B s = U S V' are the derivatives by these states, without what the other unknowns explain of them, times their standard
deviations; f tends to 1 for a wide prior.

Source: Golub, Pereyra, Inverse Problems 19 (2003) R1-R26; Gelman et al., Bayesian Data Analysis, 3rd ed. (2013),
section 14.8, on a prior as further data.
"""

from dataclasses import dataclass

import numpy as np

from motofmi.gap.models.simulation import Trajectory
from motofmi.gap.preprocessing.sampled_run import SampledRun

RANK = 1e-7  # relative singular value below which initial states are not identifiable
OFFSET_SAMPLES = 64  # samples of a segment from which sensor offsets are eliminated as well


@dataclass(frozen=True)
class SegmentStart:
    """A segment from initial states x (nx,): residuals left (m,) over the noise, and the directions of the unknowns.

    left are those at the means of the bounded states. step (nx,) is the Gauss-Newton step and gain its expected gain;
    chi2 excludes the offsets, rest is chi2 after the step. made and samples are the trajectory that contains the
    segment, and its nodes there.
    """

    x: np.ndarray
    left: np.ndarray
    taken: np.ndarray  # (m, k), orthonormal
    shares: np.ndarray  # (k,): how much of each of these directions is eliminated, 1 without a prior
    states_of_taken: np.ndarray  # (nx, k): the initial states whose change is each direction
    step: np.ndarray
    gain: float
    chi2: float
    rest: float
    made: Trajectory
    samples: slice

    @property
    def reduced(self) -> np.ndarray:
        """The residuals (m,) over the noise after the step, to first order."""
        return self.without_unknowns(self.left)

    def without_unknowns(self, of_data: np.ndarray) -> np.ndarray:
        """A quantity (m, ...) without what the unknowns explain of it."""
        return of_data - (self.taken * self.shares) @ (self.taken.T @ of_data)


@dataclass(frozen=True)
class SegmentSolution:
    """A segment from its best initial states x (nx,): output (m,) and derivatives (m, np) without unknowns, and
    mean square misfit. x_slopes (nx, np) are the derivatives of x."""

    x: np.ndarray
    output: np.ndarray
    slopes: np.ndarray
    misfit: float
    x_slopes: np.ndarray


def segment_start(
    run: SampledRun, index: int, x: np.ndarray, made: Trajectory, samples: slice, deviations: np.ndarray
) -> SegmentStart:
    """One segment of a trajectory from initial states x.

    deviations (nx,) are the standard deviations of the prior of each initial state, infinite without one; it has no
    entries where the initial states are known.
    """
    (first, last), rows = run.segments[index], run.reduction.rows[index]
    ny, deviation, unknown = run.measured.shape[1], run.deviation[rows], len(deviations)
    offsets = np.eye(ny)[:, run.with_offset if last - first >= OFFSET_SAMPLES else []]
    stack = np.zeros((last - first, ny, 1 + unknown + offsets.shape[1]))
    stack[:, :, 0] = made.outputs[samples]
    if unknown:
        stack[:, :, 1 : 1 + unknown] = made.initial_slopes[samples]  # type: ignore[index]  # asked for by states
    stack[:, :, 1 + unknown :] = offsets
    z = run.reduction.reduce(stack, index, first) / deviation[:, None]
    left, tangent = z[:, 0] - run.data[rows] / deviation, z[:, 1:]
    bounded = np.isfinite(deviations)
    prior = np.flatnonzero(bounded), deviations[bounded]
    taken, shares, unknowns_of_taken = _eliminated(tangent, *prior)
    at_means = left - tangent[:, prior[0]] @ x[prior[0]]
    pull = taken.T @ at_means
    step = -(unknowns_of_taken @ pull)[:unknown]
    step[prior[0]] -= x[prior[0]]
    reduced = at_means - taken @ (shares * pull)
    of_offsets = np.linalg.qr(tangent[:, unknown:])[0].T @ left
    return SegmentStart(
        x,
        at_means,
        taken,
        shares,
        np.concatenate([unknowns_of_taken[:unknown], np.zeros((len(x) - unknown, len(pull)))]),
        np.concatenate([step, np.zeros(len(x) - unknown)]),
        gain=float(np.sum((tangent[:, :unknown] @ step) ** 2) + np.sum((step[prior[0]] / prior[1]) ** 2)),
        chi2=float(left @ left - of_offsets @ of_offsets + np.sum((x[prior[0]] / prior[1]) ** 2)),
        rest=float(reduced @ reduced),
        made=made,
        samples=samples,
    )


def _eliminated(
    tangent: np.ndarray, bounded: np.ndarray, deviations: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Orthonormal directions (m, k) of the derivatives (m, unknowns), the share (k,) of each that is eliminated, and
    the unknowns (unknowns, k) whose change is each direction; bounded (b,) are those with a prior.

    The directions of the others come first. Those of the bounded ones, without them, are scaled by the deviations.
    """
    free = np.ones(tangent.shape[1], bool)
    free[bounded] = False
    u, size, vt = np.linalg.svd(tangent[:, free], full_matrices=False)
    kept = size > RANK * size.max(initial=1e-300)
    u, back = u[:, kept], vt[kept].T / size[kept]
    if not len(bounded):
        return u, np.ones(u.shape[1]), back
    scaled = tangent[:, bounded] * deviations
    by_free = u.T @ scaled
    further, size, vt = np.linalg.svd(scaled - u @ by_free, full_matrices=False)
    of_bounded = vt.T * (size / (1 + size**2))
    unknowns = np.zeros((tangent.shape[1], u.shape[1] + len(size)))
    unknowns[free, : u.shape[1]] = back
    unknowns[free, u.shape[1] :] = -back @ (by_free @ of_bounded)
    unknowns[bounded, u.shape[1] :] = deviations[:, None] * of_bounded
    shares = np.concatenate([np.ones(u.shape[1]), 1 - 1 / np.sqrt(1 + size**2)])
    return np.hstack([u, further]), shares, unknowns


def segment_solution(run: SampledRun, index: int, begun: SegmentStart, slopes: np.ndarray) -> SegmentSolution:
    """A segment with the derivatives (m, np) of its reduced output by all parameters, the unknowns eliminated."""
    rows, left = run.reduction.rows[index], begun.reduced
    deviation = run.deviation[rows]
    return SegmentSolution(
        x=begun.x + begun.step,
        output=run.data[rows] / deviation + left,
        slopes=begun.without_unknowns(slopes),
        misfit=float(np.mean((left * deviation) ** 2)),
        x_slopes=-begun.states_of_taken @ (begun.taken.T @ slopes),
    )
