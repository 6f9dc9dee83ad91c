"""Where the misfit of harmonics lies: by run, order and frequency band, amplitude, direction and time.

Directions are the signs of deflection and rate, and whether the excitation frequency rises or falls. Misfit while the
motion has one sign is measured by the combinations of a window's columns B that are concentrated on those samples:

    B' S B v = lambda v,   lambda > 1/2        S keeps the samples of that sign

They are orthonormal, so that residuals along them are as independent as those of the columns.

Source: Slepian, Bell Syst. Tech. J. 57 (1978) 1371-1430, whose sequences are these for one interval and one band.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from motofmi.gap.localisation.locating import Place, place
from motofmi.gap.preprocessing.steer_test_run import Output, SteerTestRun

BANDS = np.array([0.0, 1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 16, 24, 64])  # Hz
TIMES = 8  # parts of a run
STEP = 1.3  # least factor between amplitudes that are distinguished
FEWEST = 4  # data in a cell
STEADY = 0.01  # Hz from a window to the next below which the frequency counts as constant


@dataclass(frozen=True)
class _Residuals:
    """Residuals (m,) of one output of a run over the noise, with the order, frequency, time and window (m,) of each."""

    run: SteerTestRun
    output: Output
    z: np.ndarray
    order: np.ndarray
    frequency: np.ndarray
    time: np.ndarray
    window: np.ndarray
    band: np.ndarray  # of the noise spectrum

    @classmethod
    def of(cls, run: SteerTestRun, output: Output, z: np.ndarray) -> "_Residuals":
        order, frequency, time, window = (
            np.array([getattr(c, name) for c in run.reduction.columns])
            for name in ("order", "frequency", "time", "window")
        )
        edges = np.sqrt(output.noise.frequency[1:] * output.noise.frequency[:-1])
        return cls(run, output, z, order, frequency, time, window, np.searchsorted(edges, order * frequency))

    def cell(
        self, inside: np.ndarray, axis: str, low: float, high: float, unit: str, order: int | None = None
    ) -> Iterator[Place]:
        """The place of the residuals inside a mask (m,), if there are enough."""
        if np.count_nonzero(inside) >= FEWEST:
            yield self.place(self.z[inside], axis, low, high, unit, order, self.freedom(inside))

    def place(
        self, z: np.ndarray, axis: str, low: float, high: float, unit: str, order: int | None, freedom: float
    ) -> Place:
        """The place of residuals z (n,); its axis names outputs other than the effort."""
        named = axis if self.output is self.run.effort else f"{self.output.column} over {axis}"
        return place(self.run, z, named, float(low), float(high), unit, order, freedom)

    def freedom(self, inside: np.ndarray) -> float:
        """The degrees of freedom of the noise in a cell: errors of different bands are independent, those
        within a band equal."""
        share = np.bincount(self.band[inside], minlength=len(self.output.noise.freedom)) / np.count_nonzero(inside)
        return float(1 / np.sum(share**2 / np.maximum(self.output.noise.freedom, 1.0)))


def cells(run: SteerTestRun, z: np.ndarray) -> Iterator[Place]:
    """The cells of a run with residuals z (m,) over the noise, of one output after the other."""
    for output, part in zip(run.outputs, z.reshape(len(run.outputs), -1), strict=True):
        yield from of_output(run, output, part)


def of_output(run: SteerTestRun, output: Output, z: np.ndarray) -> Iterator[Place]:
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
    """Cells over the imposed motion's amplitude in a window; one cell where it hardly changes."""
    run = residuals.run
    angle = run.motion_at(run.recording.time)[0]
    size = np.array([np.ptp(angle[first:last]) / 2 for first, last, _ in run.reduction.bases])
    parts = max(int(np.log(size.max() / size.min()) / np.log(STEP)), 1)
    edges = np.geomspace(size.min(), size.max() * (1 + 1e-9), parts + 1)
    for low, high in pairwise(edges):
        yield from residuals.cell(((size >= low) & (size < high))[residuals.window], "amplitude", low, high, run.unit)


def _directions(residuals: _Residuals) -> Iterator[Place]:
    run = residuals.run
    angle, rate, _ = run.motion_at(run.recording.time)
    everywhere = residuals.freedom(np.ones(len(residuals.z), bool))
    for signal, unit in ((angle, run.unit), (rate, f"{run.unit}/s")):
        seen = np.concatenate([signal[first:last] for first, last, _ in run.reduction.bases])
        for low, high in ((float(seen.min()), 0.0), (0.0, float(seen.max()))):
            selected = np.concatenate(list(_concentrated(residuals, (signal > 0) == (high > 0))))
            yield residuals.place(selected, "direction", low, high, unit, None, everywhere)
    yield from residuals.cell(
        residuals.order % 2 == 0, "direction", -1.0, 1.0, "1"
    )  # even orders: the half cycles differ
    first = np.flatnonzero(np.diff(residuals.window, prepend=-1))
    change = np.gradient(residuals.frequency[first]) if len(first) > 1 else np.zeros(1)
    every = np.diff(residuals.time[first]).mean() if len(first) > 1 else 1.0
    for low, high, those in ((change.min(), 0.0, change < -STEADY), (0.0, change.max(), change > STEADY)):
        yield from residuals.cell(those[residuals.window], "direction", low / every, high / every, "Hz/s")


def _concentrated(residuals: _Residuals, kept: np.ndarray) -> Iterator[np.ndarray]:
    """For each window the residuals along the columns that are concentrated on the samples of a mask (n,)."""
    row = 0
    for first, last, basis in residuals.run.reduction.bases:
        part = basis[kept[first:last]]
        share, along = np.linalg.eigh(part.T @ part)
        yield along[:, share > 0.5].T @ residuals.z[row : row + basis.shape[1]]
        row += basis.shape[1]
