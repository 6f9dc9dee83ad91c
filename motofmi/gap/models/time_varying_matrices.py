"""Matrices that change over time: mappings (row, column) -> entry, a number, or an array (n,) where it changes.

Places without an entry are zero. Only entries that change over time cost computing time, in operations on long arrays.
Sums, products and inverses also take nodes of recorded operations as entries.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.linalg import lapack

Entries = Mapping[tuple[int, int], Any]  # numbers, arrays (n,), or nodes
Matrix = dict[tuple[int, int], Any]

CACHED = 4096  # steps of a band that are filled together: their part of it stays in the cache of the processor


def identity(size: int) -> Matrix:
    """The identity of so many rows."""
    return {(i, i): 1.0 for i in range(size)}


def total(a: Entries, b: Entries, weight: Any = 1.0) -> Matrix:
    """a + weight b."""
    result = dict(a)
    for place, y in b.items():
        x = weight * y
        result[place] = result[place] + x if place in result else x
    return result


def scaled(factor: Any, a: Entries) -> Matrix:
    """factor a."""
    return {place: factor * x for place, x in a.items()}


def product(a: Entries, b: Entries) -> Matrix:
    """a b."""
    by_row: dict[int, list[tuple[int, Any]]] = {}
    for (j, k), y in b.items():
        if not is_zero(y):
            by_row.setdefault(j, []).append((k, y))
    result: Matrix = {}
    for i, j in sorted(a):
        x = a[i, j]
        if not is_zero(x):
            for k, y in by_row.get(j, ()):
                result[i, k] = result[i, k] + x * y if (i, k) in result else x * y
    return result


def inverse(a: Entries, size: int) -> Matrix:
    """The inverse of a matrix of so many rows near the identity, so that no pivoting is necessary."""
    both = {place: x for place, x in a.items() if not is_zero(x)}
    both |= {(i, size + i): 1.0 for i in range(size)}
    for k in range(size):
        pivot = both[k, k]
        row = [j for j in range(k, 2 * size) if not is_zero(both.get((k, j), 0.0))]
        for j in row:
            both[k, j] = both[k, j] / pivot
        for i in range(size):
            factor = both.get((i, k), 0.0)
            if i != k and not is_zero(factor):
                for j in row:
                    both[i, j] = both.get((i, j), 0.0) - factor * both[k, j]
    return {(i, j - size): x for (i, j), x in both.items() if j >= size}


def rows(a: Entries, first: int, end: int) -> Matrix:
    """The rows first <= i < end, counted from the first of them."""
    return {(i - first, j): x for (i, j), x in a.items() if first <= i < end}


def part(a: Entries, where: slice) -> Matrix:
    """The matrix during a part of the time."""
    return {place: x[where] if isinstance(x, np.ndarray) else x for place, x in a.items()}


def is_zero(x: Any) -> bool:
    """Whether an entry is the number zero."""
    return not isinstance(x, np.ndarray) and x == 0.0


def chain(steps: Entries, nx: int, count: int) -> np.ndarray:
    """The band, as LAPACK stores it, of x_k+1 - steps_k x_k over `count` steps from x_0 = 0: the blocks -steps below
    the diagonal, which is one and not stored.

    steps (nx, nx) holds numbers, or arrays (count - 1,) from the second step on.
    """
    band = np.empty((count, nx, 2 * nx))
    for first in range(0, count, CACHED):
        block = band[first : first + CACHED]
        block[...] = 0.0
        last = min(first + CACHED, count - 1)
        for (i, j), value in steps.items():
            block[: last - first, j, nx + i - j] = -(value[first:last] if np.ndim(value) else value)
    return band.reshape(count * nx, 2 * nx).T


def carried(band: np.ndarray, forcing: np.ndarray) -> np.ndarray:
    """x_1 and on (count, nx, ...) with x_k+1 = steps_k x_k + forcing_k: a banded triangular system with a
    unit diagonal. forcing may be overwritten."""
    solution, _ = lapack.dtbtrs(band, forcing.reshape(band.shape[1], -1), uplo="L", diag="U", overwrite_b=1)
    return solution.reshape(forcing.shape)
