"""Samples as cosine coefficients of short blocks: their errors are nearly independent for any noise
with a smooth spectrum.

    c_k = sum_j y_j cos(pi k (j + 1/2) / n),   f_k = k rate / (2 n)

    var(c_k) = r_0 + 2 sum_t r_t ((1 - t / n) cos(a t) - sin(a t) / (n sin a)),   a = pi k / n

An orthonormal transform of each block (DCT-II), cut off above the band in which the outputs exceed their noise. Nothing
needs to be periodic over a block. r is the autocovariance of the noise. The variance is that of a cosine truncated at
the ends of the block: S(f_k) where the density S is smooth, plus leakage from where it is larger.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.fft import dct

from motofmi.gap.preprocessing.harmonics import Column

BLOCKS = 8  # of a long segment
SHORTEST = 256  # samples of a block, where there are several
FINE = 4  # grid points of a density per sample of a block


@dataclass
class Blocks:
    """The blocks of a run: [first, last) and the number of cosines of each that are compared; one column
    per cosine and output.

    compared (n, outputs) are the samples of the run that count; the others are zero in every signal before it is
    transformed, in the data as in the model's output. None where all count.
    """

    rate: float
    outputs: int
    spans: list[tuple[int, int, int]]
    segment_of: list[int]
    columns: list[Column]
    compared: np.ndarray | None = None

    @property
    def bases(self) -> list[tuple[int, int, None]]:
        """First and last sample of every block, once for every output."""
        return [(first, last, None) for first, last, _ in self.spans for _ in range(self.outputs)]

    def reduce(self, y: np.ndarray, segment: int | None = None, offset: int = 0) -> np.ndarray:
        """The cosines (m, ...) of signals (n, outputs, ...) that begin at sample `offset`; of one segment if given."""
        parts = []
        for first, last, kept in self.spans if segment is None else self._spans_of[segment]:
            block = dct(self._counted(y[first - offset : last - offset], first, last), axis=0, norm="ortho")[:kept]
            parts.append(np.moveaxis(block, 1, 0).reshape(self.outputs * kept, *y.shape[2:]))
        return np.concatenate(parts)

    def _counted(self, y: np.ndarray, first: int, last: int) -> np.ndarray:
        """The samples (n, outputs, ...) of a block, zero where they do not count."""
        if self.compared is None:
            return y
        counts = self.compared[first:last]
        return np.where(counts.reshape(*counts.shape, *(1,) * (y.ndim - 2)), y, 0.0)

    @cached_property
    def _spans_of(self) -> list[list[tuple[int, int, int]]]:
        """The spans of every segment."""
        return [
            [span for span, owner in zip(self.spans, self.segment_of, strict=True) if owner == segment]
            for segment in range(max(self.segment_of) + 1)
        ]

    @cached_property
    def rows(self) -> list[np.ndarray]:
        """The indices of every segment's cosines."""
        owners = np.repeat(self.segment_of, [kept * self.outputs for _, _, kept in self.spans])
        return [np.flatnonzero(owners == segment) for segment in range(max(self.segment_of) + 1)]

    def deviations(self, densities: Sequence) -> np.ndarray:
        """The standard deviation (m,) of every cosine, from the noise density of each output."""
        every = {last - first for first, last, _ in self.spans}
        known = {n: [np.sqrt(_variance(density, n, self.rate)) for density in densities] for n in every}
        return np.concatenate(
            [
                deviation[:kept] * np.sqrt(share)
                for first, last, kept in self.spans
                for deviation, share in zip(known[last - first], self._shares(first, last), strict=True)
            ]
        )

    def _shares(self, first: int, last: int) -> np.ndarray:
        """The share of each output's samples in a block that count (outputs,), at least one sample's."""
        if self.compared is None:
            return np.ones(self.outputs)
        return np.maximum(self.compared[first:last].mean(axis=0), 1 / (last - first))


def _variance(density: Callable[[np.ndarray], np.ndarray], n: int, rate: float) -> np.ndarray:
    """The variance (n,) of the cosines of a block of n samples."""
    covariance = np.fft.irfft(density(np.fft.rfftfreq(FINE * n, 1 / rate)))[:n]
    weighted = (1 - np.arange(n) / n) * covariance
    one_sided = np.fft.rfft(covariance, 2 * n)[:n]  # its imaginary part is - sum r_t sin(a t)
    variance = 2 * np.fft.rfft(weighted, 2 * n)[:n].real - covariance[0]
    variance[1:] += 2 * one_sided[1:].imag / (n * np.sin(np.pi * np.arange(1, n) / n))
    return np.maximum(variance, 1e-3 * np.min(density(np.arange(n) * rate / (2 * n))))  # rounding may leave less


def blocks_of(
    segments: Sequence[tuple[int, int]],
    outputs: int,
    rate: float,
    highest: float,
    compared: np.ndarray | None = None,
) -> Blocks:
    """The blocks of segments [first, last), with cosines up to a frequency [Hz], of the samples that are compared."""
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
                columns += [
                    Column(window, 1, output, k * rate / (2 * n), (first + last) / 2 / rate) for k in range(kept)
                ]
    return Blocks(rate, outputs, spans, owners, columns, compared)
