"""Following eigenvalues by continuation, on families of matrices whose eigenvalues are known in closed form."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.linear_analysis.eigenvalue_tracking import track_eigenvalues, unstable_intervals

GRID = np.linspace(0.0, 1.0, 11)


def family(blocks, seed=0):
    """v -> T diag(blocks(v)) T^-1 with one random T: the eigenvalues of the blocks, and none of their order."""

    def matrices(v):
        v = np.asarray(v, float)
        parts = blocks(v)
        size = sum(p.shape[-1] for p in parts)
        whole, at = np.zeros((len(v), size, size)), 0
        for part in parts:
            n = part.shape[-1]
            whole[:, at : at + n, at : at + n] = part
            at += n
        T = np.random.default_rng(seed).normal(size=(size, size)) + 2 * np.eye(size)
        return T @ whole @ np.linalg.inv(T)

    return matrices


def real(values):
    return values[:, None, None]


def pair(sigma, omega):
    return np.stack([np.stack([sigma, omega], -1), np.stack([-omega, sigma], -1)], -2)


def column_of(branches, value, at=-1):
    return int(np.argmin(np.abs(branches.eigenvalues[at] - value)))


@pytest.mark.slow
@given(seed=st.integers(0, 1000), slope=st.floats(0.5, 4), offset=st.floats(0.1, 0.9))
def test_branches_that_cross_keep_their_identity(seed, slope, offset):
    """Two pairs whose frequencies cross while their growth differs."""
    matrices = family(
        lambda v: [pair(-1 + 0 * v, 5 + slope * (v - offset)), pair(-1.3 + 0 * v, 5 - slope * (v - offset))], seed
    )
    branches = track_eigenvalues(matrices, GRID)
    column = column_of(branches, -1 + 1j * (5 + slope * (1 - offset)))
    expected = -1 + 1j * (5 + slope * (branches.parameter - offset))
    assert branches.eigenvalues[:, column] == pytest.approx(expected, abs=1e-9)


def test_branches_that_avoid_each_other_turn_off():
    """[[v, c], [c, 1 - v]]: the eigenvalues 1/2 +- sqrt((v - 1/2)^2 + c^2) never meet, however near they come."""
    c = 1e-3
    branches = track_eigenvalues(
        family(lambda v: [np.stack([np.stack([v, c + 0 * v], -1), np.stack([c + 0 * v, 1 - v], -1)], -2)]), GRID
    )
    upper = branches.eigenvalues[:, column_of(branches, 1.0)]
    assert upper == pytest.approx(0.5 + np.sqrt((branches.parameter - 0.5) ** 2 + c**2), abs=1e-9)
    assert len(branches.parameter) > 2 * len(GRID)  # it had to look more closely there


@pytest.mark.parametrize("direction", [1, -1])
def test_a_pair_that_splits_keeps_its_two_branches(direction):
    """q'' + 2 q' + k q = 0 with k through 1: a pair on one side, two real roots on the other, beside a real root at
    -1/2 - v.
    """

    def blocks(v):
        k = 1 + direction * (v - 0.45)
        return [np.stack([np.stack([0 * v, 1 + 0 * v], -1), np.stack([-k, -2 + 0 * v], -1)], -2), real(-5 - v)]

    branches = track_eigenvalues(family(blocks), GRID)
    lone = column_of(branches, -6.0)
    assert branches.eigenvalues[:, lone] == pytest.approx(-5 - branches.parameter, abs=1e-9)
    others = np.delete(branches.eigenvalues, lone, axis=1)
    assert others.sum(axis=1) == pytest.approx(-2, abs=1e-6)
    # Double roots are known to the square root of rounding only.
    assert others.prod(axis=1) == pytest.approx(1 + direction * (branches.parameter - 0.45), abs=1e-6)


def test_the_grid_asked_for_is_part_of_the_answer():
    branches = track_eigenvalues(family(lambda v: [pair(-1 + 0 * v, 5 + 3 * v), real(-2 * v)]), GRID)
    assert set(GRID) <= set(branches.parameter)
    assert branches.at(GRID).shape == (len(GRID), 3)


@pytest.mark.slow
@given(roots=st.lists(st.floats(0.02, 0.98), min_size=1, max_size=4, unique=True))
def test_intervals_of_growth_end_at_the_zeros(roots):
    """A root lambda(v) = prod (v - r_i) of simple zeros, beside stable ones that are no part of it."""
    roots = np.sort(roots)
    if np.diff(roots, prepend=0, append=1).min() < 0.02:
        return  # nearer than the grid resolves

    def growth(v):
        return 50 * np.prod([v - r for r in roots], axis=0)

    matrices = family(lambda v: [real(growth(v)), real(-100 - v), pair(-80 + 0 * v, 5 + v)])
    points = np.linspace(0, 1, 101)
    found = unstable_intervals(matrices, points, growth(points), tolerance=1e-4)
    ends = [*([0.0] if growth(0.0) > 0 else []), *roots, 1.0]  # the last factor is positive at 1
    assert np.ravel(found) == pytest.approx(ends, abs=1e-4)


def test_what_never_grows_has_no_intervals():
    points = np.linspace(0, 1, 11)
    matrices = family(lambda v: [real(-1 - v), real(-3 + 0 * v)])
    assert unstable_intervals(matrices, points, -1 - points) == []
    assert unstable_intervals(matrices, points, np.zeros(11)) == []  # what does not decay does not grow either
