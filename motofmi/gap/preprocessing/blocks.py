"""Samples as cosine coefficients of short blocks, whose errors are nearly independent for noise with a smooth spectrum.

    c_k = sum_j y_j cos(pi k (j + 1/2) / n),   f_k = k rate / (2 n)

    var(c_k) = r_0 + 2 sum_t r_t ((1 - t / n) cos(a t) - sin(a t) / (n sin a)),   a = pi k / n

This is an orthonormal transform of each block (DCT-II), cut off above the band in which the outputs exceed their noise.
Signals need not be periodic over a block. r is the autocovariance of the noise. The variance is that of a cosine
truncated at the ends of the block: S(f_k) where the density S is smooth, and leakage from frequencies at which S is
larger.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.fft import dct

MOST_BLOCKS = 8  # blocks of a long segment
SHORTEST_BLOCK = 256  # samples of a block, where a segment has several
GRID_RATIO = 4  # grid points at which a density is evaluated, per sample of a block


@dataclass(frozen=True)
class Coefficient:
    """One coefficient of one output in a block: its window, output, frequency [Hz] and the block's mean time [s]."""

    window: int
    output: int
    frequency: float
    time: float


@dataclass
class Blocks:
    """The blocks of a run with a sampling rate [Hz].

    spans are (first, last, number of coefficients that are compared) for each block, segment_of the segments of the
    blocks; there is one column per coefficient and output. compared (n, outputs) are the samples of the run that are
    compared, None where all are. The others are set to zero before the transform, in the data and in the model's
    output.
    """

    rate: float
    outputs: int
    spans: list[tuple[int, int, int]]
    segment_of: list[int]
    columns: list[Coefficient]
    compared: np.ndarray | None = None

    @cached_property
    def output_of(self) -> np.ndarray:
        """The output (m,) of each coefficient."""
        return np.array([column.output for column in self.columns])

    @property
    def bases(self) -> list[tuple[int, int, None]]:
        """First and last sample of every block, once for every output."""
        return [(first, last, None) for first, last, _ in self.spans for _ in range(self.outputs)]

    def reduce(self, y: np.ndarray) -> np.ndarray:
        """The coefficients (m, ...) of the signals (n, outputs, ...) of a run."""
        return np.concatenate(
            [self._coefficients(y[None, first:last], [first], kept)[0] for first, last, kept in self.spans]
        )

    def reduce_segments(self, y: np.ndarray, segments: Sequence[int]) -> np.ndarray:
        """The coefficients (segments, m, ...) of the signals (segments, n, outputs, ...) of `alike` segments."""
        spans = [self._spans_of[segment] for segment in segments]
        begins = [of[0][0] for of in spans]
        return np.concatenate(
            [
                self._coefficients(
                    y[:, first - begins[0] : last - begins[0]], [begin + first - begins[0] for begin in begins], kept
                )
                for first, last, kept in spans[0]
            ],
            axis=1,
        )

    def _coefficients(self, y: np.ndarray, firsts: Sequence[int], kept: int) -> np.ndarray:
        """The first coefficients (blocks, outputs * kept, ...) of the signals (blocks, n, outputs, ...) of blocks of
        one length, which begin at the samples firsts. Samples that are not compared are zero."""
        if self.compared is not None:
            compared = np.stack([self.compared[first : first + y.shape[1]] for first in firsts])
            y = np.where(compared.reshape(*compared.shape, *(1,) * (y.ndim - 3)), y, 0.0)
        block = dct(y, axis=1, norm="ortho")[:, :kept]
        return np.moveaxis(block, 2, 1).reshape(len(y), self.outputs * kept, *y.shape[3:])

    @cached_property
    def alike(self) -> list[list[int]]:
        """The segments in groups, in each of which all have blocks of the same lengths."""
        groups: dict[tuple, list[int]] = {}
        for segment, spans in enumerate(self._spans_of):
            begin = spans[0][0]
            groups.setdefault(tuple((first - begin, last - begin, kept) for first, last, kept in spans), []).append(
                segment
            )
        return list(groups.values())

    @cached_property
    def _spans_of(self) -> list[list[tuple[int, int, int]]]:
        """The spans of every segment."""
        return [
            [span for span, owner in zip(self.spans, self.segment_of, strict=True) if owner == segment]
            for segment in range(max(self.segment_of) + 1)
        ]

    @cached_property
    def rows(self) -> list[np.ndarray]:
        """The indices of the coefficients of every segment."""
        owners = np.repeat(self.segment_of, [kept * self.outputs for _, _, kept in self.spans])
        return [np.flatnonzero(owners == segment) for segment in range(max(self.segment_of) + 1)]

    def rows_of(self, segments: Sequence[int]) -> np.ndarray:
        """The indices (segments, m) of the coefficients of `alike` segments."""
        return np.array([self.rows[segment] for segment in segments])

    def deviations(self, densities: Sequence) -> np.ndarray:
        """The standard deviation (m,) of every coefficient, from the noise density of each output, in its unit."""
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
        """The share (outputs,) of the samples of a block that are compared, at least that of one sample."""
        if self.compared is None:
            return np.ones(self.outputs)
        return np.maximum(self.compared[first:last].mean(axis=0), 1 / (last - first))


def _variance(density: Callable[[np.ndarray], np.ndarray], n: int, rate: float) -> np.ndarray:
    """The variance (n,) of the coefficients of a block of n samples."""
    covariance = np.fft.irfft(density(np.fft.rfftfreq(GRID_RATIO * n, 1 / rate)))[:n]
    weighted = (1 - np.arange(n) / n) * covariance
    one_sided = np.fft.rfft(covariance, 2 * n)[:n]  # its imaginary part is - sum r_t sin(a t)
    variance = 2 * np.fft.rfft(weighted, 2 * n)[:n].real - covariance[0]
    variance[1:] += 2 * one_sided[1:].imag / (n * np.sin(np.pi * np.arange(1, n) / n))
    return np.maximum(variance, 1e-3 * np.min(density(np.arange(n) * rate / (2 * n))))  # rounding may leave less


def blocks_of(
    segments: Sequence[tuple[int, int]],
    outputs: int,
    rate: float,
    band: float,
    compared: np.ndarray | None = None,
) -> Blocks:
    """The blocks of segments [first, last), with coefficients up to a frequency `band` [Hz].

    rate is the sampling rate [Hz]; compared (n, outputs) are the samples that are compared, None for all.
    """
    spans: list[tuple[int, int, int]] = []
    owners: list[int] = []
    columns: list[Coefficient] = []
    for index, (start, end) in enumerate(segments):
        count = min(max((end - start) // SHORTEST_BLOCK, 1), MOST_BLOCKS)
        edges = np.linspace(start, end, count + 1).astype(int)
        for first, last in pairwise(edges):
            n = int(last - first)
            kept = min(int(2 * n * band / rate) + 1, n)
            spans.append((int(first), int(last), kept))
            owners.append(index)
            for output in range(outputs):
                window = (len(spans) - 1) * outputs + output
                columns += [
                    Coefficient(window, output, k * rate / (2 * n), (first + last) / 2 / rate) for k in range(kept)
                ]
    return Blocks(rate, outputs, spans, owners, columns, compared)
