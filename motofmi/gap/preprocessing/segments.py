"""An interval of a run in segments of given lengths, which may differ along it."""

from itertools import pairwise

import numpy as np

LEAST_LENGTH = 8  # samples of a segment, whatever is asked for
ROUNDING = 1e-6  # samples: accumulated rounding of sums


def segments_of(first: int, last: int, lengths: np.ndarray) -> list[tuple[int, int]]:
    """The interval [first, last) in segments of nearly the length [samples] that lengths (n,) has at their samples."""
    counted = np.concatenate([[0.0], np.cumsum(1 / lengths[first:last])])
    shares = np.linspace(0, counted[-1], max(int(counted[-1] + ROUNDING), 1) + 1)
    edges = first + np.floor(np.interp(shares, counted, np.arange(len(counted))) + ROUNDING).astype(int)
    return [(int(a), int(b)) for a, b in pairwise(edges)]
