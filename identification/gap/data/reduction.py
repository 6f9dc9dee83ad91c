"""A run on its harmonics: what a periodic excitation can cause, apart from what only noise can.

    y(t) = Re sum_k A_k(t) e^(i k phi(t)) + n(t)

In each window the amplitudes A_k are polynomials in time. Orthonormal columns q_j of these make the reduced data
q_j' y: orders 1 to 7, the first with its slope. Order 0 is left out: offsets and slow muscles are in it. What lies outside
of all columns is noise, and gives its spectrum S(f) from one run, without repeats or a model; then
var(q_j' n) = sum S(f) |Q_j(f)|^2.
A model's output passes through the same columns, so that they bias nothing. Muscles are a hundred times louder below 2 Hz than
sensors are above: without a taper h they would leak there, and the noise would come out up to a fifth too large.

    h(t) = sin(pi t / T)     (Riedel, Sidorenko, IEEE Trans. Signal Process. 43 (1995) 188-195)
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.signal import windows

from identification.gap.data.phase import Phase

ORDERS = 7  # of the reduced data
MORE_ORDERS = 20  # kept out of the noise: what strong backlash excites
BANDS = 24  # of the noise spectrum
SLOW = 3.0  # Hz: bursts of muscles below, of electronics above
INDEPENDENT = 2 / 3  # of the lines of a tapered spectrum, (sum h^2)^2 / (n sum h^4)
FEW = 4.0  # lines of a spectrum, from which a window's slow noise is known by itself


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

    def residuals(self, y: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Per window, what of y (n,) lies outside of all columns, and these columns."""
        for first, last, basis in self.outside:
            part = y[first:last]
            yield part - basis @ (basis.T @ part), basis


def reduction_of(phase: Phase, rate: float) -> Reduction:
    """The reduction of a run by its phase."""
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
    """One-sided spectrum: density (m,) at frequency (m,) [Hz], and per window the factor by which bursts raise it.

    freedom (m,) is on how many independent numbers each density rests.
    """

    frequency: np.ndarray
    density: np.ndarray
    bursts: np.ndarray  # (windows, 2): below and above SLOW
    freedom: np.ndarray

    def __call__(self, f: np.ndarray) -> np.ndarray:
        """The density at f [Hz], as a variance per sample: white noise of deviation s has density s^2."""
        return np.exp(np.interp(np.log(np.maximum(f, 1e-3)), np.log(self.frequency), np.log(self.density)))


def noise_of(reduction: Reduction, y: np.ndarray) -> Noise:
    """The noise spectrum of y (n,), from what lies outside of the harmonics."""
    edges = np.concatenate([[0.0], np.geomspace(0.6, reduction.rate / 2, BANDS)])
    flat, tapered = (_outside(reduction, y, edges, taper) for taper in (windows.boxcar, windows.cosine))  # bursts show at a window's ends too
    lines = INDEPENDENT * tapered[1].sum(axis=0)
    enough = lines > 2.0
    flat, tapered, lines = flat[..., enough], tapered[..., enough], lines[enough]
    centre = np.sqrt(np.maximum(edges[:-1], 0.3) * edges[1:])[enough]
    usual, density, bursts = np.zeros(len(centre)), np.zeros(len(centre)), np.ones((flat.shape[1], 2))
    slow, fast = centre < SLOW, centre >= SLOW
    for side, part in enumerate((slow, fast)):
        if part.any():
            usual[part], bursts[:, side] = _usual(*flat[..., part])
            density[part] = _mean(*tapered[:, bursts[:, side] == 1][..., part])
    if slow.any() and fast.any():
        power, freedom = flat[..., slow]
        bursts[:, 0] = _raised_too(bursts, power, freedom, usual[slow], usual[fast][0])
    return Noise(centre, density, bursts, 2 * lines)  # a line of the spectrum is two numbers


def _outside(reduction: Reduction, y: np.ndarray, edges: np.ndarray, taper: Callable[[int], np.ndarray]) -> np.ndarray:
    """Of what lies outside of the harmonics, under a taper, the power and the number of free lines (2, windows, bands)."""
    found = []
    for left, basis in reduction.residuals(y):
        n = len(left)
        f, h = np.fft.rfftfreq(n, 1 / reduction.rate), taper(n)
        band = np.clip(np.searchsorted(edges, f, side="right") - 1, 0, BANDS - 1)
        power = np.abs(np.fft.rfft(h * left)) ** 2 / (h @ h)
        taken = (np.abs(np.fft.rfft(h[:, None] * basis, axis=0)) ** 2).sum(axis=1) / (h @ h)
        found.append([np.bincount(band, each, BANDS) for each in (power, np.clip(1 - taken, 0, 1))])
    return np.array(found).swapaxes(0, 1)


def _mean(power: np.ndarray, freedom: np.ndarray) -> np.ndarray:
    """The density (bands,) over windows."""
    return np.maximum(power.sum(axis=0) / np.maximum(freedom.sum(axis=0), 1e-12), 1e-30)


def _usual(power: np.ndarray, freedom: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The density (bands,) of the windows without bursts, and by what each window (windows,) is above it, 1 for those."""
    scatter = 4 * np.sqrt(2 / np.maximum(freedom.sum(axis=1), 0.5))
    quiet = np.ones(len(power), bool)
    for _ in range(3):  # each time without what stood out
        density = _mean(power[quiet], freedom[quiet])
        ratio = power.sum(axis=1) / np.maximum((freedom * density).sum(axis=1), 1e-30)
        quiet = ratio <= (1 + scatter) * min(np.median(ratio), 1.0)
    return density, np.where(quiet, 1.0, np.maximum(ratio, 1.0))


def _raised_too(bursts: np.ndarray, power: np.ndarray, freedom: np.ndarray, density: np.ndarray, white: float) -> np.ndarray:
    """By what slow noise is raised (windows,) where fast noise is: bursts are broad, and a window with slow harmonics says little by itself.

    As much as its own lines say, together with FEW that say what white noise would do.
    """
    lines, usual = freedom.sum(axis=1), (freedom * density).sum(axis=1)
    expected = usual + (bursts[:, 1] - 1) * lines * np.minimum(density, white).mean()
    weight = lines / (lines + FEW)
    told = (weight * power.sum(axis=1) + (1 - weight) * expected) / np.maximum(usual, 1e-30)
    return np.where((bursts[:, 1] > 1) & (bursts[:, 0] == 1), np.maximum(told, 1.0), bursts[:, 0])


def variance_of(reduction: Reduction, noise: Noise) -> np.ndarray:
    """The variance (m,) that the noise gives each reduced number."""
    variances = []
    for index, (_, _, basis) in enumerate(reduction.bases):
        f = np.fft.rfftfreq(len(basis), 1 / reduction.rate)
        weight = np.abs(np.fft.rfft(basis, axis=0)) ** 2 / len(basis)
        weight[1:] *= 2
        if len(basis) % 2 == 0:
            weight[-1] /= 2
        burst = np.where(f < SLOW, *noise.bursts[index])
        variances.append((noise(f) * burst) @ weight)
    return np.concatenate(variances)
