"""The noise of a run without repetitions, estimated as the residuals of a flexible (nonparametric) model.

    R(f) = sum_j c_j(f) Phi_j(f) + transient(f) + N(f)

Phi_j are the spectra of possible causes of the residual: inputs, modelled motion, and powers, moduli and signs of
deflection and rate. In every narrow band each has its own complex gain, which represents any filter. The remainder N
is the estimate of the noise. It includes everything that this model cannot represent. A reduced chi-square of 1 then
means that the misfit equals that of the flexible model.

Source: Pintelon, Schoukens, System Identification, 2nd ed. (2012), ch. 7 (local polynomial method).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import digamma, polygamma

FREQUENCIES_PER_TERM = 2.5  # frequencies in a band per fitted term
HIGHEST_DEGREE = 6  # highest degree of the polynomial in frequency that smooths the logarithm of the density
SMOOTH_CHI2 = 3.0  # reduced chi-square of that polynomial above which the densities of the bands are used unsmoothed
FEWEST_FREQUENCIES = 24  # frequencies in a band


@dataclass(frozen=True)
class Density:
    """A noise density (k,): variance per sample at frequencies (k,) [Hz], its logarithm interpolated linearly.

    White noise of standard deviation s has the density s^2, in the squared unit of the signal.
    """

    frequency: np.ndarray
    density: np.ndarray

    def __call__(self, f: np.ndarray) -> np.ndarray:
        """The density at frequencies f [Hz], of any shape."""
        return np.exp(np.interp(f, self.frequency, np.log(self.density)))

    def at_least(self, least: float) -> "Density":
        """The density, bounded below by `least`."""
        return Density(self.frequency, np.maximum(self.density, least))

    def or_less(self, other: "Density") -> "Density":
        """The lesser of two densities at every frequency."""
        f = np.union1d(self.frequency, other.frequency)
        return Density(f, np.minimum(self(f), other(f)))


def features_of(
    deflections: Sequence[np.ndarray], rates: Sequence[np.ndarray], linear: Sequence[np.ndarray]
) -> list[np.ndarray]:
    """Possible causes (n,) of residuals: linear signals, then nonlinear functions of deflections and rates."""
    tau = np.linspace(-1, 1, len(linear[0]))
    found = list(linear)
    for d, s in zip(deflections, rates, strict=True):
        a, b = d / (np.abs(d).max() + 1e-30), s / (np.abs(s).max() + 1e-30)
        found += [
            a,
            b,
            a**3,
            np.tanh(b / 0.03),
            np.abs(b) * b,
            np.abs(a),
            a**2,
            tau * a,
            np.tanh(a / 0.05),
            a**2 * b,
            a**5,
            np.abs(a) * np.tanh(b / 0.05),
        ]
    return [f for f in found if np.ptp(f) > 0]


def noise_density(residual: np.ndarray, features: Sequence[np.ndarray], rate: float) -> Density:
    """The density of the part of a residual (n,) that the features (n,) do not explain.

    rate is the sampling rate [Hz]. The density is smoothed over frequency where a smooth curve fits.
    """
    spectrum = np.fft.rfft(residual)[1:] / np.sqrt(len(residual))
    n = len(spectrum)
    terms = _independent([np.fft.rfft(f)[1:] for f in features])
    terms = terms[: max(int(n / FREQUENCIES_PER_TERM) - 4, 1)]
    width = max(int(FREQUENCIES_PER_TERM * (len(terms) + 4)), FEWEST_FREQUENCIES)
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
    """The terms that are linearly independent of the earlier ones."""
    kept: list[np.ndarray] = []
    basis = np.zeros((len(terms[0]) if terms else 0, 0), complex)
    for term in terms:
        rest = term - basis @ (basis.conj().T @ term)
        if np.linalg.norm(rest) > 1e-3 * np.linalg.norm(term):
            kept.append(term)
            basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
    return kept


def _smooth(frequency: np.ndarray, logs: np.ndarray, freedoms: np.ndarray, rate: float) -> Density:
    """The polynomial through the bands with the least BIC; the bands themselves where none fits."""
    weight = 1 / np.sqrt(polygamma(1, freedoms))
    x = 4 * frequency / rate - 1
    best, chosen, misfit = np.inf, np.zeros(1), 0.0
    for degree in range(min(HIGHEST_DEGREE, max(len(logs) // 2 - 1, 0)) + 1):
        curve = np.polynomial.legendre.legfit(x, logs, degree, w=weight)
        chi2 = float(np.sum(((logs - np.polynomial.legendre.legval(x, curve)) * weight) ** 2))
        bic = chi2 + (degree + 1) * np.log(len(logs) + 1)
        if bic < best:
            best, chosen, misfit = bic, curve, chi2 / max(len(logs) - degree - 1, 1)
    if misfit > SMOOTH_CHI2 and len(logs) > 3:
        return Density(frequency, np.exp(logs))
    grid = np.linspace(frequency[0], frequency[-1], 64) if len(frequency) > 1 else frequency
    return Density(grid, np.exp(np.polynomial.legendre.legval(4 * grid / rate - 1, chosen)))
