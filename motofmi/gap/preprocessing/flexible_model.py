"""The noise of a run without repeats: what not even a very flexible model takes out of the residuals.

    R(f) = sum_j c_j(f) Phi_j(f) + transient(f) + N(f)

Phi_j are the spectra of what may have caused the residual: inputs, modelled motion, and powers, moduli and signs of
deflection and rate; in every narrow band each has a complex gain of its own, which stands for any filter. What is left
is the noise, and also whatever such a model cannot see: 1 then means as good as the flexible model.

Source: Pintelon, Schoukens, System Identification, 2nd ed. (2012), ch. 7 (local polynomial method).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import digamma, polygamma

PER_TERM = 2.5  # frequencies in a band per term that is fitted in it
HIGHEST_DEGREE = 6
MISFIT = 3.0  # of a smooth curve through the bands: above it the bands stand as they are
FEWEST = 24  # frequencies in a band


@dataclass(frozen=True)
class Density:
    """A noise density: variance per sample at frequencies f [Hz], a smooth curve or joined band by band."""

    frequency: np.ndarray
    density: np.ndarray

    def __call__(self, f: np.ndarray) -> np.ndarray:
        return np.exp(np.interp(f, self.frequency, np.log(self.density)))

    def at_least(self, least: float) -> "Density":
        """The density, nowhere below a least one."""
        return Density(self.frequency, np.maximum(self.density, least))

    def or_less(self, other: "Density") -> "Density":
        """The lesser of two, frequency by frequency."""
        f = np.union1d(self.frequency, other.frequency)
        return Density(f, np.minimum(self(f), other(f)))


def features_of(deflections: Sequence[np.ndarray], rates: Sequence[np.ndarray], linear: Sequence[np.ndarray]) -> list[np.ndarray]:
    """What residuals may be made of (n,) each: linear signals first, then functions of deflections and rates."""
    tau = np.linspace(-1, 1, len(linear[0]))
    found = list(linear)
    for d, s in zip(deflections, rates, strict=True):
        a, b = d / (np.abs(d).max() + 1e-30), s / (np.abs(s).max() + 1e-30)
        found += [a, b, a**3, np.tanh(b / 0.03), np.abs(b) * b, np.abs(a), a**2, tau * a, np.tanh(a / 0.05), a**2 * b, a**5, np.abs(a) * np.tanh(b / 0.05)]
    return [f for f in found if np.ptp(f) > 0]


def noise_density(residual: np.ndarray, features: Sequence[np.ndarray], rate: float) -> Density:
    """The density of what the features cannot explain of a residual (n,), smooth over frequency where that fits."""
    spectrum = np.fft.rfft(residual)[1:] / np.sqrt(len(residual))
    n = len(spectrum)
    terms = _independent([np.fft.rfft(f)[1:] for f in features])
    terms = terms[: max(int(n / PER_TERM) - 4, 1)]
    width = max(int(PER_TERM * (len(terms) + 4)), FEWEST)
    count = max(n // width, 1)
    edges = np.linspace(0, n, count + 1).astype(int)
    frequency, logs, freedoms = [], [], []
    for first, last in pairwise(edges):
        x = np.linspace(-1, 1, last - first)
        block = np.column_stack([t[first:last] for t in terms] + [np.ones_like(x), x, x**2, x**3])
        block = block / (np.linalg.norm(block, axis=0) + 1e-300)
        solution, _, rank, _ = np.linalg.lstsq(block, spectrum[first:last], rcond=1e-8)
        left = spectrum[first:last] - block @ solution
        freedom = last - first - int(rank)
        frequency.append((first + last) / 2 * rate / (2 * n))
        logs.append(np.log(max(float(np.sum(np.abs(left) ** 2)) / freedom, 1e-60)) + np.log(freedom) - digamma(freedom))
        freedoms.append(freedom)
    return _smooth(np.array(frequency), np.array(logs), np.array(freedoms), rate)


def _independent(terms: list[np.ndarray]) -> list[np.ndarray]:
    """The terms without those that earlier ones make up."""
    kept: list[np.ndarray] = []
    basis = np.zeros((len(terms[0]) if terms else 0, 0), complex)
    for term in terms:
        rest = term - basis @ (basis.conj().T @ term)
        if np.linalg.norm(rest) > 1e-3 * np.linalg.norm(term):
            kept.append(term)
            basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
    return kept


def _smooth(frequency: np.ndarray, logs: np.ndarray, freedoms: np.ndarray, rate: float) -> Density:
    """The curve through the bands with the least BIC; the bands themselves where none fits."""
    weight = 1 / np.sqrt(polygamma(1, freedoms))
    x = 4 * frequency / rate - 1
    best, chosen, misfit = np.inf, np.zeros(1), 0.0
    for degree in range(min(HIGHEST_DEGREE, max(len(logs) // 2 - 1, 0)) + 1):
        curve = np.polynomial.legendre.legfit(x, logs, degree, w=weight)
        chi2 = float(np.sum(((logs - np.polynomial.legendre.legval(x, curve)) * weight) ** 2))
        bic = chi2 + (degree + 1) * np.log(len(logs) + 1)
        if bic < best:
            best, chosen, misfit = bic, curve, chi2 / max(len(logs) - degree - 1, 1)
    if misfit > MISFIT and len(logs) > 3:
        return Density(frequency, np.exp(logs))
    grid = np.linspace(frequency[0], frequency[-1], 64) if len(frequency) > 1 else frequency
    return Density(grid, np.exp(np.polynomial.legendre.legval(4 * grid / rate - 1, chosen)))
