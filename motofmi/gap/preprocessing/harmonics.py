"""A run on its harmonics: what a periodic excitation can cause, apart from what only noise can.

    y(t) = Re sum_k A_k(t) e^(i k phi(t)) + n(t)

In each window the amplitudes A_k are polynomials in time. Orthonormal columns q_j of these make the reduced data
q_j' y: orders 1 to 7, the first with its slope. Order 0 is left out: offsets and slow muscles are in it. What lies outside
of all columns is noise, and gives its spectrum S(f) from one run, without repeats or a model; then
var(q_j' n) = sum S(f) |Q_j(f)|^2.
A model's output passes through the same columns, so that they bias nothing. Muscles are a hundred times louder below 2 Hz than
sensors are above: without tapers h they would leak there, and the noise would come out up to a fifth too large.

    h_k(t) = sqrt(2 / T) sin(pi k t / T)     (Riedel, Sidorenko, IEEE Trans. Signal Process. 43 (1995) 188-195)

The first one leaks least and gives the spectrum. It is blind at a window's ends, where bursts may be: all together tell those.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from identification.gap.data.phase import Phase

ORDERS = 7  # of the reduced data
MORE_ORDERS = 20  # kept out of the noise: what strong backlash excites
BANDS = 24  # of the noise spectrum
SIDES = (3.0, 12.0)  # Hz: bursts of muscles below, and where electronics take over above the fading noise of muscles
INDEPENDENT = 2 / 3  # of the lines of a tapered spectrum, (sum h^2)^2 / (n sum h^4)
TAPERS = 5


@dataclass(frozen=True)
class Column:
    """What a reduced number is: its window, order, degree in time, and mean frequency of the excitation [Hz]."""

    window: int
    order: int
    degree: int
    frequency: float
    time: float


@dataclass
class Reduction:
    """The columns of a run. `bases` are (first, last, (samples, m)) per window."""

    rate: float
    columns: list[Column]
    bases: list[tuple[int, int, np.ndarray]]
    outside: list[tuple[int, int, np.ndarray]]

    def reduce(self, y: np.ndarray) -> np.ndarray:
        """The reduced data (m, ...) of signals (n, ...)."""
        return np.concatenate([basis.T @ y[first:last] for first, last, basis in self.bases])

    def residuals(self, y: np.ndarray) -> Iterator[np.ndarray]:
        """Per window, what of y (n,) lies outside of all columns."""
        for first, last, basis in self.outside:
            part = y[first:last]
            yield part - basis @ (basis.T @ part)

    @cached_property
    def edges(self) -> np.ndarray:
        """Of the bands (BANDS + 1,) [Hz]."""
        return np.concatenate([[0.0], np.geomspace(0.6, self.rate / 2, BANDS)])

    @cached_property
    def lines(self) -> np.ndarray:
        """How many lines of a spectrum the columns leave free, (TAPERS, windows, BANDS)."""
        return np.array([self._in_bands(np.clip(1 - _power(basis).sum(axis=2), 0, 1)) for _, _, basis in self.outside]).swapaxes(0, 1)

    def left(self, y: np.ndarray) -> np.ndarray:
        """The power of y (n,) outside of all columns, (TAPERS, windows, BANDS)."""
        return np.array([self._in_bands(_power(part[:, None])[..., 0]) for part in self.residuals(y)]).swapaxes(0, 1)

    def _in_bands(self, spectra: np.ndarray) -> np.ndarray:
        """Sums over the bands of spectra (TAPERS, lines) of a window."""
        frequency = np.linspace(0, self.rate / 2, spectra.shape[1])
        band = np.clip(np.searchsorted(self.edges, frequency, side="right") - 1, 0, BANDS - 1)
        return np.array([np.bincount(band, each, BANDS) for each in spectra])


def reduction_of(phase: Phase, rate: float, hum: Sequence[float] = ()) -> Reduction:
    """The reduction of a run by its phase, without what hums at some frequencies [Hz], whatever the excitation does."""
    columns: list[Column] = []
    bases, outside = [], []
    for index, (first, last) in enumerate(phase.windows):
        n, top = last - first, phase.frequency[first:last].max()
        tau = np.linspace(-1, 1, n)
        angle, mean = phase.angle[first:last], float(phase.frequency[first:last].mean())
        raw: list[np.ndarray] = []
        labels: list[tuple[int, int]] = []
        for order in range(MORE_ORDERS + 1):
            if order * top > 0.47 * rate or len(raw) > n / 3:
                continue
            degrees = 3 if order <= 1 else 2 if order <= 3 else 1
            for degree in range(degrees):
                waves = [tau**degree * np.cos(order * angle)] + ([tau**degree * np.sin(order * angle)] if order else [])
                raw += waves
                labels += [(order, degree)] * len(waves)
        beat = 2 * np.pi * np.outer(np.arange(n) / rate, hum)
        mains = [tau**degree * wave for degree in (0, 1) for wave in (*np.cos(beat).T, *np.sin(beat).T)]  # their frequency wanders
        raw, labels = [*mains, *raw], [(0, 0)] * len(mains) + labels  # they first, so that what is kept is orthogonal to them
        q, r = np.linalg.qr(np.column_stack(raw))
        q *= np.where(np.diag(r) < 0, -1.0, 1.0)  # so that a cosine's column points along the cosine in every window
        sound = np.abs(np.diag(r)) > 1e-6 * np.abs(r).max()
        kept = [j for j, (order, degree) in enumerate(labels) if sound[j] and order <= ORDERS and degree <= (order == 1) and order]
        columns += [Column(index, *labels[j], mean, (first + last) / 2 / rate) for j in kept]
        bases.append((first, last, q[:, kept]))
        outside.append((first, last, q[:, sound]))
    return Reduction(rate, columns, bases, outside)


@dataclass(frozen=True)
class Noise:
    """One-sided spectrum: density (m,) at frequency (m,) [Hz]. Bursts add white noise to windows (windows,), and raise what is there on some SIDES.

    freedom (m,) is on how many independent numbers each density rests, raised (windows, 3) the factors below, between and above the SIDES.
    """

    frequency: np.ndarray
    density: np.ndarray
    freedom: np.ndarray
    added: np.ndarray
    raised: np.ndarray

    def __call__(self, f: np.ndarray) -> np.ndarray:
        """The density at f [Hz], as a variance per sample: white noise of deviation s has density s^2."""
        return np.exp(np.interp(np.log(np.maximum(f, 1e-3)), np.log(self.frequency), np.log(self.density)))

    def of_window(self, window: int, f: np.ndarray) -> np.ndarray:
        """The same of a window, with its bursts."""
        return self.raised[window][np.searchsorted(SIDES, f, side="right")] * (self(f) + self.added[window])


def noise_of(reduction: Reduction, y: np.ndarray) -> Noise:
    """The noise spectrum of y (n,), from what lies outside of the harmonics."""
    power, free = reduction.left(y), reduction.lines
    flat, tapered = np.array([power.mean(axis=0), free.mean(axis=0)]), np.array([power[0], free[0]])
    lines, edges = INDEPENDENT * tapered[1].sum(axis=0), reduction.edges
    enough = lines > 2.0
    flat, tapered, lines = flat[..., enough], tapered[..., enough], lines[enough]
    centre = np.sqrt(np.maximum(edges[:-1], 0.3) * edges[1:])[enough]
    side = np.searchsorted(SIDES, centre, side="right")
    density, added, raised = np.zeros(len(centre)), np.zeros(flat.shape[1]), np.ones((flat.shape[1], len(SIDES) + 1))
    for each in np.unique(side)[::-1]:  # from the fast side, where muscles do not hide a white burst
        part = side == each
        usual, above = _usual(flat[0][:, part], flat[1][:, part], added)
        density[part] = _mean(*tapered[:, (above == 1) & (added == 0)][..., part])
        if each == len(SIDES):
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
    """The density (bands,) over windows."""
    return np.maximum(power.sum(axis=0) / np.maximum(freedom.sum(axis=0), 1e-12), 1e-30)


def _usual(power: np.ndarray, freedom: np.ndarray, added: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The density (bands,) of windows without bursts, and by what each (windows,) is above it and what is added, 1 for those that may be by chance."""
    scatter = 4 * np.sqrt(2 / np.maximum(freedom.sum(axis=1), 0.5))
    quiet = added == 0
    for _ in range(3):  # each time without what stood out
        density = _mean(power[quiet], freedom[quiet])
        ratio = power.sum(axis=1) / np.maximum((freedom * (density + added[:, None])).sum(axis=1), 1e-30)
        low = ratio <= (1 + scatter) * min(np.median(ratio[added == 0]), 1.0)
        quiet = low & (added == 0)
    return density, np.where(low, 1.0, np.maximum(ratio, 1.0))


def variance_of(reduction: Reduction, noise: Noise) -> np.ndarray:
    """The variance (m,) that the noise gives each reduced number."""
    variances = []
    for index, (_, _, basis) in enumerate(reduction.bases):
        f = np.fft.rfftfreq(len(basis), 1 / reduction.rate)
        weight = np.abs(np.fft.rfft(basis, axis=0)) ** 2 / len(basis)
        weight[1:] *= 2
        if len(basis) % 2 == 0:
            weight[-1] /= 2
        variances.append(noise.of_window(index, f) @ weight)
    return np.concatenate(variances)
