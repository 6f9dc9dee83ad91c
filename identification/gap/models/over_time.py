"""Matrices that change over time: arrays of objects whose entries are numbers, or arrays (n,) where they change.

Zeros and what is constant cost nothing, and the rest runs at the speed of long arrays, however small the matrix is.
"""

from typing import Any

import numpy as np
from scipy.linalg import lapack


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a b, of shapes (i, j) and (j, k)."""
    result = np.zeros((a.shape[0], b.shape[1])).astype(object)
    for i, row in enumerate(a):
        for k, column in enumerate(b.T):
            for x, y in zip(row, column, strict=True):
                if not is_zero(x) and not is_zero(y):
                    result[i, k] = x * y if is_zero(result[i, k]) else result[i, k] + x * y
    return result


def inverse(a: np.ndarray) -> np.ndarray:
    """The inverse of (i, i) near the identity, so that no pivot needs to be looked for."""
    size = len(a)
    both = np.concatenate([a, np.eye(size)], axis=1).astype(object)
    for k in range(size):
        pivot = both[k, k]
        for j in range(k, 2 * size):
            both[k, j] = both[k, j] if is_zero(both[k, j]) else both[k, j] / pivot
        for i in range(size):
            factor = both[i, k]
            if i != k and not is_zero(factor):
                for j in range(k, 2 * size):
                    both[i, j] = both[i, j] if is_zero(both[k, j]) else both[i, j] - factor * both[k, j]
    return both[:, size:]


def part(a: np.ndarray, where: slice) -> np.ndarray:
    """The matrix during a part of the time."""
    result = a.copy()
    for place, x in np.ndenumerate(a):
        if isinstance(x, np.ndarray):
            result[place] = x[where]
    return result


def is_zero(x: Any) -> bool:
    """Whether an entry is the number zero."""
    return not isinstance(x, np.ndarray) and x == 0.0


def chain(steps: np.ndarray, count: int) -> np.ndarray:
    """The band, as LAPACK stores it, of x_k+1 - steps_k x_k over `count` steps from x_0 = 0: the identity, below which stand the blocks -steps.

    steps (nx, nx) holds numbers, or arrays (count - 1,) from the second step on.
    """
    nx = len(steps)
    band = np.zeros((2 * nx, count * nx), order="F")
    band[0] = 1.0
    for (i, j), value in np.ndenumerate(steps):
        band[nx + i - j, j : (count - 1) * nx : nx] = -value
    return band


def carried(band: np.ndarray, push: np.ndarray) -> np.ndarray:
    """x_1 and on (count, nx, ...) with x_k+1 = steps_k x_k + push_k: a banded triangular system. push may be overwritten."""
    solution, _ = lapack.dtbtrs(band, push.reshape(band.shape[1], -1), uplo="L", overwrite_b=1)
    return solution.reshape(push.shape)
