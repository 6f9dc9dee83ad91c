"""Samples on the cosines of short blocks: data that are nearly independent for any noise with a smooth spectrum.

    c_k = sum_j y_j cos(pi k (j + 1/2) / n),   f_k = k rate / (2 n)

    var(c_k) = r_0 + 2 sum_t r_t ((1 - t / n) cos(a t) - sin(a t) / (n sin a)),   a = pi k / n

An orthonormal transform of each block, cut off above the band in which the outputs hold anything but noise. A block
begins and ends where it likes: nothing needs to be periodic. r is the noise's autocovariance, and the variance that of a
cosine cut off at the block's ends: S(f_k) where the density S is smooth, and what leaks from where it is larger.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.fft import dct

from identification.gap.data.reduction import Column

BLOCKS = 8  # of a long segment
SHORTEST = 256  # samples of a block, where there are several
FINE = 4  # points of a density's grid per sample of a block


@dataclass
class Blocks:
    """The blocks of a run: [first, last) and how many cosines of each are kept; one column per cosine and output."""

    rate: float
    outputs: int
    spans: list[tuple[int, int, int]]
    segment_of: list[int]
    columns: list[Column]

    @property
    def bases(self) -> list[tuple[int, int, None]]:
        """First and last sample of every block, once for every output."""
        return [(first, last, None) for first, last, _ in self.spans for _ in range(self.outputs)]

    def reduce(self, y: np.ndarray, segment: int | None = None, offset: int = 0) -> np.ndarray:
        """The cosines (m, ...) of signals (n, outputs, ...) that begin at sample `offset`; of one segment if given."""
        parts = []
        for first, last, kept in self.spans if segment is None else self._spans_of[segment]:
            block = dct(y[first - offset : last - offset], axis=0, norm="ortho")[:kept]
            parts.append(np.moveaxis(block, 1, 0).reshape(self.outputs * kept, *y.shape[2:]))
        return np.concatenate(parts)

    @cached_property
    def _spans_of(self) -> list[list[tuple[int, int, int]]]:
        """The spans of every segment."""
        return [[span for span, owner in zip(self.spans, self.segment_of, strict=True) if owner == segment] for segment in range(max(self.segment_of) + 1)]

    @cached_property
    def rows(self) -> list[np.ndarray]:
        """The places of every segment's cosines among all."""
        owners = np.repeat(self.segment_of, [kept * self.outputs for _, _, kept in self.spans])
        return [np.flatnonzero(owners == segment) for segment in range(max(self.segment_of) + 1)]

    def deviations(self, densities: Sequence) -> np.ndarray:
        """The deviation (m,) of every cosine, from each output's density as a function of frequency."""
        every = {last - first for first, last, _ in self.spans}
        known = {n: [np.sqrt(_variance(density, n, self.rate)) for density in densities] for n in every}
        return np.concatenate([deviation[:kept] for first, last, kept in self.spans for deviation in known[last - first]])


def _variance(density: Callable[[np.ndarray], np.ndarray], n: int, rate: float) -> np.ndarray:
    """The variance (n,) of the cosines of a block of n samples."""
    covariance = np.fft.irfft(density(np.fft.rfftfreq(FINE * n, 1 / rate)))[:n]
    weighed = (1 - np.arange(n) / n) * covariance
    ahead = np.fft.rfft(covariance, 2 * n)[:n]  # of which the imaginary part is - sum r_t sin(a t)
    variance = 2 * np.fft.rfft(weighed, 2 * n)[:n].real - covariance[0]
    variance[1:] += 2 * ahead[1:].imag / (n * np.sin(np.pi * np.arange(1, n) / n))
    return np.maximum(variance, 1e-3 * np.min(density(np.arange(n) * rate / (2 * n))))  # rounding beside what is much larger


def blocks_of(segments: Sequence[tuple[int, int]], outputs: int, rate: float, highest: float) -> Blocks:
    """The blocks of segments [first, last), with cosines up to a frequency [Hz]."""
    spans: list[tuple[int, int, int]] = []
    owners: list[int] = []
    columns: list[Column] = []
    for index, (start, end) in enumerate(segments):
        count = min(max((end - start) // SHORTEST, 1), BLOCKS)
        edges = np.linspace(start, end, count + 1).astype(int)
        for first, last in pairwise(edges):
            n = int(last - first)
            kept = min(int(2 * n * highest / rate) + 1, n)
            spans.append((int(first), int(last), kept))
            owners.append(index)
            for output in range(outputs):
                window = (len(spans) - 1) * outputs + output
                columns += [Column(window, 1, output, k * rate / (2 * n), (first + last) / 2 / rate) for k in range(kept)]
    return Blocks(rate, outputs, spans, owners, columns)
