"""Where a model misses sampled runs: by output, frequency, time, size and direction of the motion.

The residuals z of a block, of white noise if the model does not miss, are a signal C z over time. Its power in the samples
S of one direction is a sum of squares of numbers that depend on each other, with the mean and variance

    E |S C z|^2 = tr G,   var = 2 tr G^2,   G = C' S C

and a chi-square with the same two is taken for it.

Source: Satterthwaite, Biometrics Bulletin 2 (1946) 110-114.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from scipy.fft import idct
from scipy.stats import chi2

from identification.gap.data.sampled import Sampled
from identification.gap.reporting.locating import Place, place

PARTS = 8  # of the band, and of the run
SIZES = 4


def cells(run: Sampled, z: np.ndarray) -> Iterator[Place]:
    """The cells of a run with residuals (m,) over the noise."""
    columns = run.reduction.columns
    frequency, time, output = (np.array([getattr(c, what) for c in columns]) for what in ("frequency", "time", "degree"))
    for index, name in enumerate(run.test.outputs):
        if len(run.test.outputs) > 1:
            yield place(run, z[output == index], f"output {name}", float(index), float(index), "1")
    yield from _along(run, z, "frequency", "Hz", frequency, PARTS)
    yield from _along(run, z, "time", "s", time, PARTS)
    spans = run.reduction.bases
    size = np.array([np.ptp(run.measured[first:last, i % len(run.test.outputs)]) / 2 for i, (first, last, _) in enumerate(spans)])
    yield from _along(run, z, "amplitude", run.recording.units[run.test.outputs[0]], size[[c.window for c in columns]], SIZES)
    yield from _directions(run, z)


def _along(run: Sampled, z: np.ndarray, axis: str, unit: str, at: np.ndarray, parts: int) -> Iterator[Place]:
    edges = np.linspace(at.min(), at.max() * 1.0001 + 1e-12, parts + 1)
    for low, high in pairwise(edges):
        inside = (at >= low) & (at < high)
        if np.count_nonzero(inside) >= 4:
            yield place(run, z[inside], axis, float(low), float(high), unit)


def _directions(run: Sampled, z: np.ndarray) -> Iterator[Place]:
    """Both sides of the middle, and both ways of moving, as far as the motion is within the band that is compared."""
    motion, outputs, row = run.moved(run.recording.time)[0], run.reduction.outputs, 0
    motion = motion - np.median(motion)
    blocks = []  # waves (n, kept), residuals (kept, outputs), and motion and rate (n,) over each block
    for first, last, kept in run.reduction.spans:
        waves = idct(np.eye(last - first, kept), axis=0, norm="ortho")
        smooth = waves @ (waves.T @ motion[first:last])
        blocks.append((waves, z[row : row + kept * outputs].reshape(outputs, kept).T, (smooth, np.gradient(smooth) * run.recording.rate)))
        row += kept * outputs
    for index, unit in enumerate((run.unit, f"{run.unit}/s")):
        ends = [min(moved[index].min() for *_, moved in blocks), max(moved[index].max() for *_, moved in blocks)]
        for end in ends:
            power, mean, square = 0.0, 0.0, 0.0
            for waves, residuals, moved in blocks:
                there = waves[np.sign(moved[index]) == np.sign(end)]
                power += float(np.sum((there @ residuals) ** 2))
                mean += outputs * float(np.sum(there**2))
                gram = there @ there.T if len(there) < there.shape[1] else there.T @ there  # the smaller one: tr G^2 is that of either
                square += outputs * float(np.sum(gram**2))
            if square:
                yield Place(run.name, "direction", min(end, 0.0), max(end, 0.0), unit, power / mean - 1, float(chi2.sf(power * mean / square, mean**2 / square)))
