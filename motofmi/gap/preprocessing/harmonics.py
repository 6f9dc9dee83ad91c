"""Reduction of a run to harmonics of its excitation, and its noise spectrum from the signal outside the harmonics.

    y(t) = Re sum_k A_k(t) e^(i k phi(t)) + n(t)

In each window the amplitudes A_k are polynomials in time. The reduced data are q_j' y, with orthonormal columns q_j of
these: orders 1 to 7, the first with its slope. Order 0 is left out, since it contains offsets and the slow part of the
rider's remnant. The part of the signal outside all columns is noise. It gives the noise spectrum S(f) from one run,
without repetitions and without a model; then var(q_j' n) = sum S(f) |Q_j(f)|^2. The model output is projected on the
same columns, so that they cause no bias. The remnant below 2 Hz has a hundred times the power of the sensor noise above
it. Without tapers h_k it would leak there, and the noise would be estimated up to a fifth too large.

    h_k(t) = sqrt(2 / T) sin(pi k t / T)     (Riedel, Sidorenko, IEEE Trans. Signal Process. 43 (1995) 188-195)

The first taper has the least leakage and gives the spectrum. It vanishes at the ends of a window; therefore bursts are
detected with all tapers.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from motofmi.gap.preprocessing.excitation_phase import Phase

ORDERS = 7  # highest order of the reduced data
EXCLUDED_ORDERS = 20  # highest order that is excluded from the noise: strong backlash excites as many
BANDS = 24  # bands of the noise spectrum
# Hz: bursts of the rider's remnant are below the first frequency; above the second there is only sensor noise.
SIDE_FREQUENCIES = (3.0, 12.0)
INDEPENDENT_SHARE = 2 / 3  # share of independent lines in a tapered spectrum, (sum h^2)^2 / (n sum h^4)
TAPERS = 5


@dataclass(frozen=True)
class Column:
    """One reduced datum: its window, order, degree in time, mean excitation frequency [Hz] and time [s]."""

    window: int
    order: int
    degree: int
    frequency: float
    time: float


@dataclass
class Reduction:
    """The columns of a run with a sampling rate [Hz].

    bases are (first, last, (samples, m)) for each window, the columns of the reduced data; outside are the same with
    all columns that are excluded from the noise.
    """

    rate: float
    columns: list[Column]
    bases: list[tuple[int, int, np.ndarray]]
    outside: list[tuple[int, int, np.ndarray]]

    def reduce(self, y: np.ndarray) -> np.ndarray:
        """The reduced data (m, ...) of signals (n, ...)."""
        return np.concatenate([basis.T @ y[first:last] for first, last, basis in self.bases])

    def residuals(self, y: np.ndarray) -> Iterator[np.ndarray]:
        """For each window the part of y (n,) outside all columns."""
        for first, last, basis in self.outside:
            part = y[first:last]
            yield part - basis @ (basis.T @ part)

    @cached_property
    def edges(self) -> np.ndarray:
        """The edges of the bands (BANDS + 1,) [Hz]."""
        return np.concatenate([[0.0], np.geomspace(0.6, self.rate / 2, BANDS)])

    @cached_property
    def lines(self) -> np.ndarray:
        """The number of spectral lines outside the columns, (TAPERS, windows, BANDS)."""
        lines = [self._in_bands(np.clip(1 - _power(basis).sum(axis=2), 0, 1)) for _, _, basis in self.outside]
        return np.array(lines).swapaxes(0, 1)

    def power_outside(self, y: np.ndarray) -> np.ndarray:
        """The power of y (n,) outside all columns, (TAPERS, windows, BANDS)."""
        return np.array([self._in_bands(_power(part[:, None])[..., 0]) for part in self.residuals(y)]).swapaxes(0, 1)

    def _in_bands(self, spectra: np.ndarray) -> np.ndarray:
        """Spectra (TAPERS, lines) of a window summed over the bands."""
        frequency = np.linspace(0, self.rate / 2, spectra.shape[1])
        band = np.clip(np.searchsorted(self.edges, frequency, side="right") - 1, 0, BANDS - 1)
        return np.array([np.bincount(band, each, BANDS) for each in spectra])


def reduction_of(phase: Phase, rate: float, interference: Sequence[float] = ()) -> Reduction:
    """The reduction of a run by its phase, without mains interference at the given frequencies [Hz]."""
    columns: list[Column] = []
    bases, outside = [], []
    for index, (first, last) in enumerate(phase.windows):
        n, top = last - first, phase.frequency[first:last].max()
        tau = np.linspace(-1, 1, n)
        angle, mean = phase.angle[first:last], float(phase.frequency[first:last].mean())
        raw: list[np.ndarray] = []
        labels: list[tuple[int, int]] = []
        for order in range(EXCLUDED_ORDERS + 1):
            if order * top > 0.47 * rate or len(raw) > n / 3:
                continue
            degrees = 3 if order <= 1 else 2 if order <= 3 else 1
            for degree in range(degrees):
                waves = [tau**degree * np.cos(order * angle)] + ([tau**degree * np.sin(order * angle)] if order else [])
                raw += waves
                labels += [(order, degree)] * len(waves)
        mains_phase = 2 * np.pi * np.outer(np.arange(n) / rate, interference)
        waves = [*np.cos(mains_phase).T, *np.sin(mains_phase).T]
        mains = [tau**degree * wave for degree in (0, 1) for wave in waves]  # linear: the mains frequency drifts
        # They come first, so that the reduced data are orthogonal to them.
        raw, labels = [*mains, *raw], [(0, 0)] * len(mains) + labels
        q, r = np.linalg.qr(np.column_stack(raw))
        q *= np.where(np.diag(r) < 0, -1.0, 1.0)  # so that a cosine's column points along the cosine in every window
        sound = np.abs(np.diag(r)) > 1e-6 * np.abs(r).max()
        kept = [
            j
            for j, (order, degree) in enumerate(labels)
            if sound[j] and order <= ORDERS and degree <= (order == 1) and order
        ]
        columns += [Column(index, *labels[j], mean, (first + last) / 2 / rate) for j in kept]
        bases.append((first, last, q[:, kept]))
        outside.append((first, last, q[:, sound]))
    return Reduction(rate, columns, bases, outside)


@dataclass(frozen=True)
class Noise:
    """A one-sided noise spectrum: density (m,) at frequency (m,) [Hz].

    In a window with a burst the density is larger. freedom (m,) is the number of independent data behind each density,
    added (windows,) is the density of the white noise of a burst, raised (windows, 3) are the factors on the density
    below, between and above the `SIDE_FREQUENCIES`.
    """

    frequency: np.ndarray
    density: np.ndarray
    freedom: np.ndarray
    added: np.ndarray
    raised: np.ndarray

    def __call__(self, f: np.ndarray) -> np.ndarray:
        """The density at f [Hz] as variance per sample: white noise of standard deviation s has the density s^2."""
        return np.exp(np.interp(np.log(np.maximum(f, 1e-3)), np.log(self.frequency), np.log(self.density)))

    def of_window(self, window: int, f: np.ndarray) -> np.ndarray:
        """The density in a window, with its bursts."""
        return self.raised[window][np.searchsorted(SIDE_FREQUENCIES, f, side="right")] * (self(f) + self.added[window])


def noise_of(reduction: Reduction, y: np.ndarray) -> Noise:
    """The noise spectrum of y (n,) from the signal outside the harmonics."""
    power, free = reduction.power_outside(y), reduction.lines
    flat, tapered = np.array([power.mean(axis=0), free.mean(axis=0)]), np.array([power[0], free[0]])
    lines, edges = INDEPENDENT_SHARE * tapered[1].sum(axis=0), reduction.edges
    enough = lines > 2.0
    flat, tapered, lines = flat[..., enough], tapered[..., enough], lines[enough]
    centre = np.sqrt(np.maximum(edges[:-1], 0.3) * edges[1:])[enough]
    side = np.searchsorted(SIDE_FREQUENCIES, centre, side="right")
    windows = flat.shape[1]
    density, added = np.zeros(len(centre)), np.zeros(windows)
    raised = np.ones((windows, len(SIDE_FREQUENCIES) + 1))
    for each in np.unique(side)[::-1]:  # from the highest frequencies, where the remnant does not hide a white burst
        part = side == each
        usual, above = _without_bursts(flat[0][:, part], flat[1][:, part], added)
        density[part] = _mean(*tapered[:, (above == 1) & (added == 0)][..., part])
        if each == len(SIDE_FREQUENCIES):
            added = (above - 1) * np.average(usual, weights=lines[part])
        else:
            raised[:, each] = above
    return Noise(centre, density, 2 * lines, added, raised)  # a line of the spectrum is two numbers


def _power(y: np.ndarray) -> np.ndarray:
    """The spectra (TAPERS, lines, m) of signals (n, m) under each taper."""
    n = len(y)
    tapers = np.sin(np.pi * np.outer(np.arange(1, TAPERS + 1), np.arange(n) + 0.5) / n) * np.sqrt(2 / n)
    return np.array([np.abs(np.fft.rfft(h[:, None] * y, axis=0)) ** 2 for h in tapers])


def _mean(power: np.ndarray, freedom: np.ndarray) -> np.ndarray:
    """The mean density (bands,) of windows, from their power and numbers of lines (windows, bands)."""
    return np.maximum(power.sum(axis=0) / np.maximum(freedom.sum(axis=0), 1e-12), 1e-30)


def _without_bursts(power: np.ndarray, freedom: np.ndarray, added: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The density (bands,) of windows without bursts, and the factor (windows,) of each window over it.

    The factor is 1 where its excess may be due to chance.
    """
    scatter = 4 * np.sqrt(2 / np.maximum(freedom.sum(axis=1), 0.5))
    quiet = added == 0
    for _ in range(3):  # each time without the windows that exceeded the last density
        density = _mean(power[quiet], freedom[quiet])
        ratio = power.sum(axis=1) / np.maximum((freedom * (density + added[:, None])).sum(axis=1), 1e-30)
        low = ratio <= (1 + scatter) * min(np.median(ratio[added == 0]), 1.0)
        quiet = low & (added == 0)
    return density, np.where(low, 1.0, np.maximum(ratio, 1.0))


def variance_of(reduction: Reduction, noise: Noise) -> np.ndarray:
    """The variance (m,) of each reduced datum due to the noise."""
    variances = []
    for index, (_, _, basis) in enumerate(reduction.bases):
        f = np.fft.rfftfreq(len(basis), 1 / reduction.rate)
        weight = np.abs(np.fft.rfft(basis, axis=0)) ** 2 / len(basis)
        weight[1:] *= 2
        if len(basis) % 2 == 0:
            weight[-1] /= 2
        variances.append(noise.of_window(index, f) @ weight)
    return np.concatenate(variances)
