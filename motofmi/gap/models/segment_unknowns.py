"""The unknowns of each segment, its initial states and sensor offsets, eliminated from its residuals.

    r - T (T' r),   dm/dq - T (T' dm/dq)

r are the residuals over the noise, and T is an orthonormal basis of their derivatives by the unknowns (variable
projection). An initial state of an effect that is bounded by the effect's equations has a normal prior of mean zero.
Such states b are eliminated by their joint distribution with the data,

    (1 + B s s' B')^(-1/2) r = r - U f (U' r),   f = 1 - (1 + S^2)^(-1/2)

B s = U S V' are the derivatives by these states, without what the other unknowns explain of them, times their standard
deviations; f tends to 1 for a wide prior. Segments with arrays of the same shapes are computed together.

Source: Golub, Pereyra, Inverse Problems 19 (2003) R1-R26; Gelman et al., Bayesian Data Analysis, 3rd ed. (2013),
section 14.8, on a prior as further data.
"""

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from motofmi.gap.models.simulation import Trajectory
from motofmi.gap.preprocessing.sampled_run import SampledRun

RANK = 1e-7  # relative singular value below which initial states are not identifiable
OFFSET_SAMPLES = 64  # samples of a segment from which sensor offsets are eliminated as well


@dataclass(frozen=True)
class SegmentStart:
    """A segment from initial states x (nx,), and the directions of its unknowns.

    reduced (m,) are the residuals over the noise without the unknowns, to first order. step (nx,) is the Gauss-Newton
    step and gain its expected gain; chi2 excludes the offsets, rest is chi2 after the step. made and samples are the
    trajectory that contains the segment, and its nodes there.
    """

    x: np.ndarray
    reduced: np.ndarray
    taken: np.ndarray  # (m, k), orthonormal; zero where a direction is not identifiable
    shares: np.ndarray  # (k,): how much of each of these directions is eliminated, 1 without a prior
    states_of_taken: np.ndarray  # (nx, k): the initial states whose change is each direction
    step: np.ndarray
    gain: float
    chi2: float
    rest: float
    made: Trajectory
    samples: slice


@dataclass(frozen=True)
class SegmentSolution:
    """A segment from its best initial states x (nx,): output (m,) and derivatives (m, np) without unknowns, and
    mean square misfit. x_slopes (nx, np) are the derivatives of x."""

    x: np.ndarray
    output: np.ndarray
    slopes: np.ndarray
    misfit: float
    x_slopes: np.ndarray


def groups(run: SampledRun, segments: Container[int]) -> Iterator[list[int]]:
    """Those of some segments whose arrays have the same shapes, together."""
    of_run = ([i for i in alike if i in segments] for alike in run.reduction.alike)
    return (alike for alike in of_run if alike)


def segment_starts(
    run: SampledRun,
    initial: Mapping[int, np.ndarray],
    made: Trajectory,
    samples: Mapping[int, slice],
    deviations: np.ndarray,
) -> dict[int, SegmentStart]:
    """Segments of a trajectory that are alike (see `groups`), each from its initial states (nx,).

    samples are the nodes of each in the trajectory. deviations (nx,) are the standard deviations of the prior of each
    initial state, infinite without one; it has no entries where the initial states are known. The first axis of all
    arrays is that of the segments.
    """
    alike, x = list(initial), np.array(list(initial.values()))
    length, ny, unknown = int(np.subtract(*run.segments[alike[0]][::-1])), run.measured.shape[1], len(deviations)
    offsets = np.eye(ny)[:, run.with_offset if length >= OFFSET_SAMPLES else []]
    stack = np.zeros((len(alike), length, ny, 1 + unknown + offsets.shape[1]))
    stack[..., 0] = [made.outputs[samples[i]] for i in alike]
    if unknown:
        slopes = made.initial_slopes
        stack[..., 1 : 1 + unknown] = [slopes[samples[i]] for i in alike]  # type: ignore[index]  # asked for by states
    stack[..., 1 + unknown :] = offsets
    rows = run.reduction.rows_of(alike)
    z = run.reduction.reduce_segments(stack, alike) / run.deviation[rows][..., None]
    left, tangent = z[..., 0] - run.data[rows] / run.deviation[rows], z[..., 1:]
    bounded = np.isfinite(deviations)
    prior = np.flatnonzero(bounded), deviations[bounded]
    taken, shares, unknowns_of_taken = _eliminated(tangent, *prior)
    at_means = left - _applied(tangent[..., prior[0]], x[:, prior[0]])
    pull = _applied(taken.transpose(0, 2, 1), at_means)
    step = -_applied(unknowns_of_taken, pull)[:, :unknown]
    step[:, prior[0]] -= x[:, prior[0]]
    reduced = at_means - _applied(taken, shares * pull)
    gain = np.sum(_applied(tangent[..., :unknown], step) ** 2, axis=1)
    chi2 = np.sum(left**2, axis=1)
    if offsets.shape[1]:
        chi2 -= np.sum(_applied(np.linalg.qr(tangent[..., unknown:])[0].transpose(0, 2, 1), left) ** 2, axis=1)
    known = np.zeros((len(alike), x.shape[1] - unknown))
    of_states = np.concatenate([unknowns_of_taken[:, :unknown], np.zeros((*known.shape, pull.shape[1]))], axis=1)
    steps = np.concatenate([step, known], axis=1)
    gain += np.sum((step[:, prior[0]] / prior[1]) ** 2, axis=1)
    chi2 += np.sum((x[:, prior[0]] / prior[1]) ** 2, axis=1)
    rest = np.sum(reduced**2, axis=1)
    return {
        i: SegmentStart(
            x[k], reduced[k], taken[k], shares[k], of_states[k], steps[k], float(gain[k]), float(chi2[k]),
            float(rest[k]), made, samples[i],
        )
        for k, i in enumerate(alike)
    }  # fmt: skip


def _applied(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """The products (segments, m) of matrices (segments, m, k) and vectors (segments, k)."""
    return (matrices @ vectors[..., None])[..., 0]


def _eliminated(
    tangent: np.ndarray, bounded: np.ndarray, deviations: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Orthonormal directions (segments, m, k) of the derivatives (segments, m, unknowns), the share (segments, k) of
    each that is eliminated, and the unknowns (segments, unknowns, k) whose change is each direction; bounded (b,) are
    those with a prior.

    The directions of the others come first; those that are not identifiable are zero. Those of the bounded ones,
    without them, are scaled by the deviations.
    """
    free = np.ones(tangent.shape[2], bool)
    free[bounded] = False
    u, size, vt = np.linalg.svd(tangent[..., free], full_matrices=False)
    kept = size > RANK * size.max(axis=1, initial=1e-300, keepdims=True)
    u = u * kept[:, None]
    back = vt.transpose(0, 2, 1) * np.divide(1.0, size, out=np.zeros_like(size), where=kept)[:, None]
    if not len(bounded):
        return u, np.ones(size.shape), back
    scaled = tangent[..., bounded] * deviations
    by_free = u.transpose(0, 2, 1) @ scaled
    further, spread, vt = np.linalg.svd(scaled - u @ by_free, full_matrices=False)
    of_bounded = vt.transpose(0, 2, 1) * (spread / (1 + spread**2))[:, None]
    unknowns = np.zeros((len(tangent), tangent.shape[2], size.shape[1] + spread.shape[1]))
    unknowns[:, free, : size.shape[1]] = back
    unknowns[:, free, size.shape[1] :] = -back @ (by_free @ of_bounded)
    unknowns[:, bounded, size.shape[1] :] = deviations[:, None] * of_bounded
    shares = np.concatenate([np.ones(size.shape), 1 - 1 / np.sqrt(1 + spread**2)], axis=1)
    return np.concatenate([u, further], axis=2), shares, unknowns


def segment_solutions(
    run: SampledRun, alike: Sequence[int], begun: Mapping[int, SegmentStart], slopes: np.ndarray
) -> dict[int, SegmentSolution]:
    """Segments that are alike, with the derivatives (segments, m, np) of their reduced outputs by all parameters, the
    unknowns eliminated."""
    taken, shares, of_states, reduced = (
        np.array([getattr(begun[i], name) for i in alike]) for name in ("taken", "shares", "states_of_taken", "reduced")
    )
    of_taken = taken.transpose(0, 2, 1) @ slopes
    rows = run.reduction.rows_of(alike)
    deviation = run.deviation[rows]
    output = run.data[rows] / deviation + reduced
    left = slopes - taken @ (shares[..., None] * of_taken)
    misfit = np.mean((reduced * deviation) ** 2, axis=1)
    x_slopes = -of_states @ of_taken
    return {
        i: SegmentSolution(begun[i].x + begun[i].step, output[k], left[k], float(misfit[k]), x_slopes[k])
        for k, i in enumerate(alike)
    }
