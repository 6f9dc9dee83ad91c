"""The unknowns of one segment, its initial states and sensor offsets, eliminated from its residuals.

    r - T (T' r),   dm/dq - T (T' dm/dq)

r are the residuals over the noise, and T is an orthonormal basis of their derivatives by the unknowns (variable
projection).

Source: Golub, Pereyra, Inverse Problems 19 (2003) R1-R26.
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

    step (nx,) is the Gauss-Newton step and gain its expected gain; chi2 excludes the offsets, rest is chi2 after the
    step. made and samples are the trajectory that contains the segment, and its nodes there.
    """

    x: np.ndarray
    left: np.ndarray
    taken: np.ndarray  # (m, unknowns), orthonormal
    states_of_taken: np.ndarray  # (nx, unknowns): the initial states whose change is each direction
    step: np.ndarray
    gain: float
    chi2: float
    rest: float
    made: Trajectory
    samples: slice

    @property
    def reduced(self) -> np.ndarray:
        """The residuals (m,) over the noise after the step, to first order."""
        return self.left - self.taken @ (self.taken.T @ self.left)


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
    run: SampledRun, index: int, x: np.ndarray, made: Trajectory, samples: slice, unknown: int
) -> SegmentStart:
    """One segment of a trajectory from initial states x, of which the first `unknown` (all or none) are eliminated."""
    (first, last), rows = run.segments[index], run.reduction.rows[index]
    ny, deviation = run.measured.shape[1], run.deviation[rows]
    offsets = np.eye(ny)[:, run.with_offset if last - first >= OFFSET_SAMPLES else []]
    stack = np.zeros((last - first, ny, 1 + unknown + offsets.shape[1]))
    stack[:, :, 0] = made.outputs[samples]
    if unknown:
        stack[:, :, 1 : 1 + unknown] = made.initial_slopes[samples]  # type: ignore[index]  # asked for by states
    stack[:, :, 1 + unknown :] = offsets
    z = run.reduction.reduce(stack, index, first) / deviation[:, None]
    left, tangent = z[:, 0] - run.data[rows] / deviation, z[:, 1:]
    u, size, vt = np.linalg.svd(tangent, full_matrices=False)
    kept = size > RANK * size.max(initial=1e-300)
    u, pull = u[:, kept], u[:, kept].T @ left
    states_of_taken = np.zeros((len(x), int(np.sum(kept))))
    states_of_taken[:unknown] = (vt[kept].T / size[kept])[:unknown]
    step = -states_of_taken @ pull
    of_offsets = np.linalg.qr(tangent[:, unknown:])[0].T @ left
    return SegmentStart(
        x,
        left,
        u,
        states_of_taken,
        step,
        gain=float(np.sum((tangent[:, :unknown] @ step[:unknown]) ** 2)),
        chi2=float(left @ left - of_offsets @ of_offsets),
        rest=float(left @ left - pull @ pull),
        made=made,
        samples=samples,
    )


def segment_solution(run: SampledRun, index: int, begun: SegmentStart, slopes: np.ndarray) -> SegmentSolution:
    """A segment with the derivatives (m, np) of its reduced output by all parameters, the unknowns eliminated."""
    rows, left = run.reduction.rows[index], begun.reduced
    deviation, by_unknowns = run.deviation[rows], begun.taken.T @ slopes
    return SegmentSolution(
        x=begun.x + begun.step,
        output=run.data[rows] / deviation + left,
        slopes=slopes - begun.taken @ by_unknowns,
        misfit=float(np.mean((left * deviation) ** 2)),
        x_slopes=-begun.states_of_taken @ by_unknowns,
    )
