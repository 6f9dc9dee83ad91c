"""Where a model misses harmonics: by run, order and frequency band, amplitude, direction and time.

Directions are the sides to which the motion is deflected and turns, and whether the excitation's frequency rises or
falls. What happens while the motion has one sign is seen by those combinations of a window's columns B that live there:

    B' S B v = lambda v,   lambda > 1/2        S keeps the samples of that sign

They are orthonormal, so that residuals along them are as independent as those of the columns.

Source: Slepian, Bell Syst. Tech. J. 57 (1978) 1371-1430, whose sequences are these for one interval and one band.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from identification.gap.data.runs import Output, Run
from identification.gap.reporting.locating import Place, place

BANDS = np.array([0.0, 1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 16, 24, 64])  # Hz
TIMES = 8  # parts of a run
STEP = 1.3  # factor between amplitudes that count as different
FEWEST = 4  # numbers in a cell
STEADY = 0.01  # Hz from a window to the next, below which the frequency stays


@dataclass(frozen=True)
class _Residuals:
    """Those of an output of a run (m,) over the noise, and what each of them is (m,)."""

    run: Run
    output: Output
    z: np.ndarray
    order: np.ndarray
    frequency: np.ndarray
    time: np.ndarray
    window: np.ndarray
    band: np.ndarray  # of the noise spectrum

    @classmethod
    def of(cls, run: Run, output: Output, z: np.ndarray) -> "_Residuals":
        order, frequency, time, window = (np.array([getattr(c, name) for c in run.reduction.columns]) for name in ("order", "frequency", "time", "window"))
        edges = np.sqrt(output.noise.frequency[1:] * output.noise.frequency[:-1])
        return cls(run, output, z, order, frequency, time, window, np.searchsorted(edges, order * frequency))

    def cell(self, inside: np.ndarray, axis: str, low: float, high: float, unit: str, order: int | None = None) -> Iterator[Place]:
        """The place of the residuals that are inside (m,), if they are enough."""
        if np.count_nonzero(inside) >= FEWEST:
            yield self.place(self.z[inside], axis, low, high, unit, order, self.freedom(inside))

    def place(self, z: np.ndarray, axis: str, low: float, high: float, unit: str, order: int | None, freedom: float) -> Place:
        """The place of residuals z (n,); outputs besides the effort are named."""
        named = axis if self.output is self.run.effort else f"{self.output.column} over {axis}"
        return place(self.run, z, named, float(low), float(high), unit, order, freedom)

    def freedom(self, inside: np.ndarray) -> float:
        """On how many numbers the noise in a cell rests: bands of its spectrum err independently, numbers of a band alike."""
        share = np.bincount(self.band[inside], minlength=len(self.output.noise.freedom)) / np.count_nonzero(inside)
        return float(1 / np.sum(share**2 / np.maximum(self.output.noise.freedom, 1.0)))


def cells(run: Run, z: np.ndarray) -> Iterator[Place]:
    """The cells of a run with residuals z (m,) over the noise, of one output after the other."""
    for output, part in zip(run.outputs, z.reshape(len(run.outputs), -1), strict=True):
        yield from of_output(run, output, part)


def of_output(run: Run, output: Output, z: np.ndarray) -> Iterator[Place]:
    """The cells of one output with residuals z (m,) over the noise."""
    residuals, time = _Residuals.of(run, output, z), run.recording.time
    yield from residuals.cell(np.ones(len(z), bool), "run", time[0], time[-1], "s")
    yield from _orders_and_bands(residuals)
    for low, high in pairwise(np.linspace(time[0], time[-1], TIMES + 1)):
        yield from residuals.cell((residuals.time >= low) & (residuals.time < high), "time", low, high, "s")
    yield from _amplitudes(residuals)
    yield from _directions(residuals)


def _orders_and_bands(residuals: _Residuals) -> Iterator[Place]:
    every = np.ones(len(residuals.z), bool)
    for order in (None, *np.unique(residuals.order)):
        mine = every if order is None else residuals.order == order
        if order is not None:
            yield from residuals.cell(mine, "order", order, order, "1", int(order))
        for low, high in pairwise(BANDS):
            inside = mine & (residuals.frequency >= low) & (residuals.frequency < high)
            yield from residuals.cell(inside, "frequency", low, high, "Hz", None if order is None else int(order))


def _amplitudes(residuals: _Residuals) -> Iterator[Place]:
    """Bins of the imposed motion's amplitude by window: one where it hardly changes."""
    run = residuals.run
    angle = run.moved(run.recording.time)[0]
    size = np.array([np.ptp(angle[first:last]) / 2 for first, last, _ in run.reduction.bases])
    parts = max(int(np.log(size.max() / size.min()) / np.log(STEP)), 1)
    edges = np.geomspace(size.min(), size.max() * (1 + 1e-9), parts + 1)
    for low, high in pairwise(edges):
        yield from residuals.cell(((size >= low) & (size < high))[residuals.window], "amplitude", low, high, run.unit)


def _directions(residuals: _Residuals) -> Iterator[Place]:
    run = residuals.run
    angle, rate, _ = run.moved(run.recording.time)
    everywhere = residuals.freedom(np.ones(len(residuals.z), bool))
    for moved, unit in ((angle, run.unit), (rate, f"{run.unit}/s")):
        seen = np.concatenate([moved[first:last] for first, last, _ in run.reduction.bases])
        for low, high in ((float(seen.min()), 0.0), (0.0, float(seen.max()))):
            lived = np.concatenate(list(_living(residuals, (moved > 0) == (high > 0))))
            yield residuals.place(lived, "direction", low, high, unit, None, everywhere)
    yield from residuals.cell(residuals.order % 2 == 0, "direction", -1.0, 1.0, "1")  # what differs between the half cycles
    first = np.flatnonzero(np.diff(residuals.window, prepend=-1))
    change = np.gradient(residuals.frequency[first]) if len(first) > 1 else np.zeros(1)
    every = np.diff(residuals.time[first]).mean() if len(first) > 1 else 1.0
    for low, high, those in ((change.min(), 0.0, change < -STEADY), (0.0, change.max(), change > STEADY)):
        yield from residuals.cell(those[residuals.window], "direction", low / every, high / every, "Hz/s")


def _living(residuals: _Residuals, kept: np.ndarray) -> Iterator[np.ndarray]:
    """Per window, the residuals along what lives in the samples that are kept (n,)."""
    row = 0
    for first, last, basis in residuals.run.reduction.bases:
        part = basis[kept[first:last]]
        share, along = np.linalg.eigh(part.T @ part)
        yield along[:, share > 0.5].T @ residuals.z[row : row + basis.shape[1]]
        row += basis.shape[1]
