"""Where a model misses the data: run, order, frequency, amplitude, direction and time, with p-values.

The residuals of a cell are noise unless the model misses there: their sum of squares then is chi-square distributed.
Of all cells those are kept whose p-values pass a stated false-discovery rate.

Source: Benjamini, Hochberg, J. R. Statist. Soc. B 57 (1995) 289-300.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import chi2, false_discovery_control

from identification.gap.data.reduction import Column
from identification.gap.data.runs import Run
from identification.gap.models.model import AnyRun
from identification.gap.naming.fitting import Fit

FALSE_DISCOVERIES = 0.01
BANDS = np.array([0.0, 1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 16, 24, 64])  # Hz
TIMES = 8  # parts of a run


@dataclass(frozen=True)
class Place:
    """A cell along an axis, with the reduced chi-square minus 1 there and the chance of as much from noise alone."""

    run: str
    axis: str
    start: float
    end: float
    unit: str
    excess: float
    p_value: float


Cells = Callable[[Any, np.ndarray], Iterator[Place]]  # of a run and its residuals over the noise


def locate(found: Fit, rate: float = FALSE_DISCOVERIES, cells: Cells | None = None) -> list[Place]:
    """The cells in which the fit misses the data, the clearest first. cells says what they are; those of harmonics else."""
    places, first = [], 0
    for run in found.runs:
        last = first + len(run.data)
        places += list((cells or _places)(run, found.residuals[first:last]))
        first = last
    places.sort(key=lambda p: (p.p_value, -p.excess))
    adjusted = false_discovery_control([p.p_value for p in places]) if places else []
    return [p for p, least_rate in zip(places, adjusted, strict=True) if least_rate <= rate]


def _places(run: Run, z: np.ndarray) -> Iterator[Place]:
    columns = run.reduction.columns
    yield from _along(run, z, "order", "1", np.arange(0.5, 8.5), lambda c: c.order, whole=True)
    yield from _along(run, z, "frequency", "Hz", BANDS, lambda c: c.frequency)
    end = max(c.time for c in columns) + 1.0
    yield from _along(run, z, "time", "s", np.linspace(0, end, TIMES + 1), lambda c: c.time)
    size = _amplitudes(run)
    edges = np.linspace(0, size.max() * 1.001, 5)
    yield from _along(run, z, "amplitude", run.unit, edges, lambda c: size[c.window])
    even = np.array([c.order % 2 == 0 for c in columns])
    if even.any():
        yield place(run, z[even], "direction", -1.0, 1.0, "1")


def _along(run: Run, z: np.ndarray, axis: str, unit: str, edges: np.ndarray, of: Callable[[Column], float], whole: bool = False) -> Iterator[Place]:
    cell = np.searchsorted(edges, [of(c) for c in run.reduction.columns], side="right") - 1
    for i in range(len(edges) - 1):
        inside = cell == i
        if np.count_nonzero(inside) >= 4:
            low, high = (edges[i] + 0.5, edges[i] + 0.5) if whole else (edges[i], edges[i + 1])
            yield place(run, z[inside], axis, float(low), float(high), unit)


def place(run: AnyRun, z: np.ndarray, axis: str, low: float, high: float, unit: str) -> Place:
    power = float(z @ z)
    return Place(run.name, axis, low, high, unit, power / len(z) - 1, float(chi2.sf(power, len(z))))


def _amplitudes(run: Run) -> np.ndarray:
    """The amplitude of the imposed motion in each window (w,)."""
    angle = run.moved(run.recording.time)[0]
    return np.array([np.ptp(angle[first:last]) / 2 for first, last, _ in run.reduction.bases])
