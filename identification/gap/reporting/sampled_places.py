"""Where a model misses sampled runs: by output, frequency, time, and size of the motion."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

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


def _along(run: Sampled, z: np.ndarray, axis: str, unit: str, at: np.ndarray, parts: int) -> Iterator[Place]:
    edges = np.linspace(at.min(), at.max() * 1.0001 + 1e-12, parts + 1)
    for low, high in pairwise(edges):
        inside = (at >= low) & (at < high)
        if np.count_nonzero(inside) >= 4:
            yield place(run, z[inside], axis, float(low), float(high), unit)
