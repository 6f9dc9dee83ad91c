"""Where the misfit of sampled runs lies: by output, frequency, time, amplitude and direction of the motion.

The residuals z of a block, white noise where the model is true, are a signal C z over time. Its power in the samples
S of one direction is a sum of squares of dependent numbers, with the mean and variance

    E |S C z|^2 = tr G,   var = 2 tr G^2,   G = C' S C

and is approximated by a chi-square distribution with the same mean and variance.

Source: Satterthwaite, Biometrics Bulletin 2 (1946) 110-114.
"""

from collections.abc import Iterator
from functools import cache
from itertools import pairwise

import numpy as np
from scipy.fft import idct
from scipy.special import chdtrc

from motofmi.gap.localisation.locating import Place, place
from motofmi.gap.preprocessing.sampled_run import SampledRun

PARTS = 8  # of the band, and of the run
SIZES = 4  # cells over the amplitude


def cells(run: SampledRun, z: np.ndarray) -> Iterator[Place]:
    """The cells of a run with residuals (m,) over the noise."""
    columns = run.reduction.columns
    frequency, time = (np.array([getattr(c, what) for c in columns]) for what in ("frequency", "time"))
    for index, name in enumerate(run.experiment.outputs):
        if len(run.experiment.outputs) > 1:
            yield place(run, z[run.reduction.output_of == index], f"output {name}", float(index), float(index), "1")
    yield from _along(run, z, "frequency", "Hz", frequency, PARTS)
    yield from _along(run, z, "time", "s", time, PARTS)
    motion = run.motion_at(run.recording.time)[0]
    size = np.array([np.ptp(motion[first:last]) / 2 for first, last, _ in run.reduction.bases])
    yield from _along(run, z, "amplitude", run.unit, size[[c.window for c in columns]], SIZES)
    yield from _directions(run, z)


def _along(run: SampledRun, z: np.ndarray, axis: str, unit: str, at: np.ndarray, parts: int) -> Iterator[Place]:
    edges = np.linspace(at.min(), at.max() * 1.0001 + 1e-12, parts + 1)
    for low, high in pairwise(edges):
        inside = (at >= low) & (at < high)
        if np.count_nonzero(inside) >= 4:
            yield place(run, z[inside], axis, float(low), float(high), unit)


def _directions(run: SampledRun, z: np.ndarray) -> Iterator[Place]:
    """Both signs of deflection (about the median) and of rate, of the motion within the compared band."""
    motion, outputs, row = run.motion_at(run.recording.time)[0], run.reduction.outputs, 0
    motion = motion - np.median(motion)
    cosines = cache(lambda n, kept: idct(np.eye(n, kept), axis=0, norm="ortho"))  # many blocks have the same length
    blocks = []  # waves (n, kept), residuals (kept, outputs), and motion and rate (n,) over each block
    for first, last, kept in run.reduction.spans:
        waves = cosines(last - first, kept)
        smooth = waves @ (waves.T @ motion[first:last])
        blocks.append(
            (
                waves,
                z[row : row + kept * outputs].reshape(outputs, kept).T,
                (smooth, np.gradient(smooth) * run.recording.rate),
            )
        )
        row += kept * outputs
    for index, unit in enumerate((run.unit, f"{run.unit}/s")):
        ends = [
            min(signals[index].min() for *_, signals in blocks),
            max(signals[index].max() for *_, signals in blocks),
        ]
        for end in ends:
            power, mean, square = 0.0, 0.0, 0.0
            for waves, residuals, signals in blocks:
                there = waves[np.sign(signals[index]) == np.sign(end)]
                power += float(np.sum((there @ residuals) ** 2))
                mean += outputs * float(np.sum(there**2))
                gram = (
                    there @ there.T if len(there) < there.shape[1] else there.T @ there
                )  # the smaller one: tr G^2 is that of either
                square += outputs * float(np.sum(gram**2))
            if square:
                yield Place(
                    run.name,
                    "direction",
                    min(end, 0.0),
                    max(end, 0.0),
                    unit,
                    power / mean - 1,
                    float(chdtrc(mean**2 / square, power * mean / square)),
                )
