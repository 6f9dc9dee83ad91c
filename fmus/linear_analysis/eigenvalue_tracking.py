"""Tracking of eigenvalues over a parameter such as the speed, so that each branch keeps its identity.

Neighbouring spectra are matched by nearest neighbours. A match is accepted where every eigenvalue moves much less than
the distance to the next one; otherwise the interval is subdivided. Intervals that remain below the smallest step
contain an exceptional point, where a complex pair becomes two real roots or the reverse: there the spectra are
assigned to each other with the least total distance (linear sum assignment).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Matrices = Callable[[np.ndarray], np.ndarray]  # parameters (n,) -> matrices (n, nx, nx)
StackedMatrices = Callable[[np.ndarray, np.ndarray], np.ndarray]  # members (n,), parameters (n,) -> matrices

SAFE_MOVE = 0.35  # of the distance to the nearest other eigenvalue; a match is unique below one half
DIVIDED_BY = 5
SMALLEST_STEP = 5e-3  # in the unit of the parameter
# The same for many families at once, where the grid is as coarse as the user's: every match that is unique is taken.
UNIQUE_MOVE, SMALLEST_HALF = 0.48, 5e-2
TILT = 1e-6  # of the eigenvalue: far above rounding errors, far below what a smallest step changes


@dataclass(frozen=True)
class Branches:
    """Eigenvalues (n, nx) over ascending parameters (n,); each column is one branch."""

    parameter: np.ndarray
    eigenvalues: np.ndarray

    def at(self, parameters: np.ndarray) -> np.ndarray:
        """The eigenvalues (m, nx) at parameters (m,) of the grid."""
        return self.eigenvalues[np.searchsorted(self.parameter, parameters - 1e-9)]


def track_eigenvalues(matrices: Matrices, grid: np.ndarray) -> Branches:
    """The eigenvalues of `matrices` over an ascending grid (n,), refined where they cannot be matched.

    matrices maps parameters (n,) to matrices (n, nx, nx).
    """
    points = np.asarray(grid, float)
    spectra = np.linalg.eigvals(matrices(points)).astype(complex)
    order, sure = matches(spectra[:-1], spectra[1:])
    while len(refine := np.flatnonzero(~sure & (np.diff(points) > SMALLEST_STEP))):
        inner = np.linspace(points[refine], points[refine + 1], DIVIDED_BY + 1, axis=1)[:, 1:-1]
        between = np.linalg.eigvals(matrices(inner.ravel())).astype(complex).reshape(*inner.shape, -1)
        chain = np.concatenate([spectra[refine, None], between, spectra[refine + 1, None]], axis=1)
        new_order, new_sure = matches(np.concatenate(chain[:, :-1]), np.concatenate(chain[:, 1:]))
        place = np.repeat(refine + 1, DIVIDED_BY - 1)
        order[refine], sure[refine] = new_order[::DIVIDED_BY], new_sure[::DIVIDED_BY]
        later = np.arange(len(new_sure)) % DIVIDED_BY > 0
        order, sure = np.insert(order, place, new_order[later], axis=0), np.insert(sure, place, new_sure[later])
        points, spectra = (
            np.insert(points, place, inner.ravel()),
            np.insert(spectra, place, np.concatenate(between), axis=0),
        )
    for k in np.flatnonzero(~sure):
        order[k] = _assignment(spectra[k], spectra[k + 1])
    return Branches(points, _in_branch_order(spectra, order))


def track_stacked(matrices: StackedMatrices, members: int, grid: np.ndarray) -> np.ndarray:
    """The eigenvalues (members, n, nx) of several families of matrices over one ascending grid (n,), one branch in each
    column.

    matrices maps member indices (m,) and parameters (m,) to matrices (m, nx, nx). The branches are those of
    `track_eigenvalues`, in the order of the last spectrum.
    """
    count = len(grid)
    member, points = np.repeat(np.arange(members), count), np.tile(grid, members)
    spectra = np.linalg.eigvals(matrices(member, points)).astype(complex).reshape(members, count, -1)
    width = spectra.shape[2]
    left, right = (part.reshape(-1, width) for part in (spectra[:, :-1], spectra[:, 1:]))
    order = _connected(matrices, np.repeat(np.arange(members), count - 1), np.tile(grid[:-1], members),
                       np.tile(grid[1:], members), left, right).reshape(members, count - 1, width)  # fmt: skip
    place = np.tile(np.arange(width), (members, 1))
    found = np.empty_like(spectra)
    found[:, -1] = spectra[:, -1]
    for k in range(count - 2, -1, -1):
        place = np.take_along_axis(order[:, k].argsort(axis=1), place, axis=1)
        found[:, k] = np.take_along_axis(spectra[:, k], place, axis=1)
    return found


def _connected(matrices: StackedMatrices, member: np.ndarray, low: np.ndarray, high: np.ndarray, left: np.ndarray,
               right: np.ndarray) -> np.ndarray:  # fmt: skip
    """For intervals from `low` to `high` (n,) with spectra left and right (n, nx): the index in `right` of the branch
    of every eigenvalue of `left`. Intervals without a unique match are halved."""
    order, sure = matches(left, right, UNIQUE_MOVE)
    if len(wide := np.flatnonzero(~sure & (high - low > SMALLEST_HALF))):
        who, middle = member[wide], (low[wide] + high[wide]) / 2
        between = np.linalg.eigvals(matrices(who, middle)).astype(complex)
        halves = _connected(matrices, np.tile(who, 2), np.concatenate([low[wide], middle]),
                            np.concatenate([middle, high[wide]]), np.concatenate([left[wide], between]),
                            np.concatenate([between, right[wide]]))  # fmt: skip
        order[wide] = np.take_along_axis(halves[len(wide) :], halves[: len(wide)], axis=1)
    for k in np.flatnonzero(~sure & (high - low <= SMALLEST_HALF)):
        order[k] = _assignment(left[k], right[k])
    return order


def _assignment(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The index in `right` (nx,) of every eigenvalue of `left` with the least total distance.

    Both eigenvalues of a pair have the same distance to each of two real roots, and the order of LAPACK must not
    decide: on the left the upper half is moved to the left, on the right to the right, so that real roots that form a
    pair and part again continue as if they had passed through each other.
    """
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415 - imported on use: it takes 0.5 s

    left, right = (s + side * TILT * np.sign(s.imag) * np.abs(s) for s, side in ((left, -1), (right, 1)))
    return linear_sum_assignment(np.abs(left[:, None] - right[None, :]))[1]


def _in_branch_order(spectra: np.ndarray, order: np.ndarray) -> np.ndarray:
    """The spectra (n, nx) with one branch per column, in the order of the last spectrum."""
    sorted_spectra = spectra.copy()
    place = np.arange(spectra.shape[1])  # of branch i in the spectrum at hand
    after = len(spectra) - 1  # place is right for all spectra up to this one
    for k in np.flatnonzero((order != np.arange(spectra.shape[1])).any(axis=1))[::-1]:
        sorted_spectra[k + 1 : after + 1] = spectra[k + 1 : after + 1, place]
        place, after = np.argsort(order[k])[place], k
    sorted_spectra[: after + 1] = spectra[: after + 1, place]
    return sorted_spectra


def matches(left: np.ndarray, right: np.ndarray, safe: float = SAFE_MOVE) -> tuple[np.ndarray, np.ndarray]:
    """For each pair of spectra (n, nx): the index in `right` of every eigenvalue of `left`, and whether the match is
    unique.

    LAPACK mostly keeps the order from one spectrum to the next, so that order is tried before all pairs are compared.
    """
    count = right.shape[1]
    gaps = _distances(right, right)
    gaps[:, np.arange(count), np.arange(count)] = np.inf
    isolation = gaps.min(axis=2)
    order = np.tile(np.arange(count), (len(right), 1))
    sure = (np.abs(left - right) <= safe * np.sqrt(isolation)).all(axis=1)
    if len(rest := np.flatnonzero(~sure)):
        moves = _distances(left[rest], right[rest])
        order[rest] = nearest = moves.argmin(axis=2)
        one_to_one = (np.sort(nearest, axis=1) == np.arange(count)).all(axis=1)
        allowed = safe**2 * np.take_along_axis(isolation[rest], nearest, axis=1)
        sure[rest] = one_to_one & (moves.min(axis=2) <= allowed).all(axis=1)
    return order, sure


def _distances(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Squared distances (n, nx, nx) between all pairs."""
    total = np.ascontiguousarray(left.real)[:, :, None] - np.ascontiguousarray(right.real)[:, None, :]
    total *= total
    across = np.ascontiguousarray(left.imag)[:, :, None] - np.ascontiguousarray(right.imag)[:, None, :]
    across *= across
    total += across
    return total


def unstable_intervals(
    matrices: Matrices, points: np.ndarray, growth: np.ndarray, tolerance: float = 1e-2
) -> list[list[float]]:
    """The intervals [from, to] of the parameter in which a mode is unstable, with refined ends.

    points (n,), growth (n,): the largest real part of the mode's eigenvalues there; NaN where the mode is absent, at
    which an interval ends.
    """
    unstable = growth > 0
    edges = np.flatnonzero(unstable[1:] != unstable[:-1])
    ends = [_zero(points[k : k + 2], growth[k : k + 2], matrices, tolerance) for k in edges]
    if unstable[0]:
        ends.insert(0, float(points[0]))
    if unstable[-1]:
        ends.append(float(points[-1]))
    return [ends[i : i + 2] for i in range(0, len(ends), 2)]


def _zero(points: np.ndarray, growth: np.ndarray, matrices: Matrices, tolerance: float) -> float:
    """The parameter between two points at which a real part changes its sign, by the method of false position."""
    (a, b), (fa, fb) = points, growth
    if np.isnan(growth).any():
        return float(b if np.isnan(fa) else a)
    while b - a > tolerance:
        middle = (a * fb - b * fa) / (fb - fa)
        middle = min(max(middle, a + tolerance / 2), b - tolerance / 2)
        values = np.linalg.eigvals(matrices(np.array([middle]))[0]).real
        value = values[np.argmin(np.abs(values - (fa + (fb - fa) * (middle - a) / (b - a))))]
        if value == 0:
            return float(middle)
        if (value > 0) == (fa > 0):
            a, fa = middle, value
        else:
            b, fb = middle, value
    return float((a * fb - b * fa) / (fb - fa))
