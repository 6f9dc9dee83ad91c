"""Frequency response functions from recordings, by band averages of the whole record's spectra.

    inertance H = S_ar / S_Mr,     a = -omega^2 delta

a is the angular acceleration of the handlebar, M the torque, and r the reference of the cross-spectra:
  - the torque itself: S_aM / S_MM, the estimator of both papers. The rider's own torque noise is in S_MM,
    so it reads low wherever the rider is not quite passive;
  - the steer angle, which the servo imposes: S_aa / S_Ma, unbiased by noise in the torque;
  - the commanded angle, where the rig logs it: unbiased by noise in the angle too.

In each band the part of r that a polynomial in frequency can explain is taken out of it. What the ends of
a record leak into its spectrum is such a polynomial, so starts and ends do no harm (the idea of the local
polynomial method: Pintelon, Schoukens, System Identification, 2nd ed., ch. 7).

A band average sees the apparent inertia A = M/a through weights, A_band = sum w_k A(f_k). The FRF keeps
these weights, so a model can be compared as the same estimator would see it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.fft import rfft

from fmus.errors import InputError, unknown
from identification.recordings import Recording
from identification.sampling import uniform

REFERENCES = ("steer_angle_command", "steer_angle", "steer_torque")
LEAKAGE_TERMS = 2  # the polynomial in frequency that a band gives up to the ends of the record
NODES = np.cos(pi * np.arange(8, -1, -1) / 8)  # where in a band a model is evaluated: exact up to the eighth power
CENTRE = np.eye(9, dtype=complex)[4]  # the weights of a measurement at one frequency
LINES = 12  # of the spectrum, that a band needs at least
NARROW, WIDE = 0.25, 2.0  # Hz
EMPTY = 0.01  # a band with less of the strongest band's excitation than this holds no measurement


@dataclass(frozen=True)
class FRF:
    """An estimated inertance over n bands.

    frequency (n,) [Hz], inertance (n,) complex [(rad/s2)/(N.m)], variance (n,) of the apparent inertia
    1/inertance, E|error|^2 [kg2.m4], coherence (n,), weights (n, 9) complex of the apparent inertia at
    `nodes` (n, 9) [Hz]. modulus_deviation and phase_deviation [rad] (n,) over the `runs` that it is the mean
    of, NaN for fewer than two.
    """

    name: str
    frequency: np.ndarray
    inertance: np.ndarray
    variance: np.ndarray
    coherence: np.ndarray
    nodes: np.ndarray
    weights: np.ndarray
    modulus_deviation: np.ndarray
    phase_deviation: np.ndarray
    runs: np.ndarray
    reference: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def omega(self) -> np.ndarray:
        return 2 * pi * self.frequency

    @property
    def receptance(self) -> np.ndarray:
        """Angle over torque [rad/(N.m)]."""
        return self.inertance / -(self.omega**2)

    @property
    def impedance(self) -> np.ndarray:
        """Torque over rate [N.m.s/rad]."""
        return 1j * self.omega / self.inertance

    @property
    def apparent_inertia(self) -> np.ndarray:
        """Torque over acceleration [kg.m2]."""
        return 1 / self.inertance

    @property
    def standard_error(self) -> np.ndarray:
        """Of the inertance's modulus, and relative to it of the phase [rad] (n,)."""
        return np.abs(self.inertance) ** 2 * np.sqrt(self.variance / 2)

    def confidence(self, factor: float = 1.96) -> tuple[np.ndarray, np.ndarray]:
        """Half widths (n,) of the modulus [(rad/s2)/(N.m)] and of the phase [rad]; 1.96 is 95 %."""
        return factor * self.standard_error, factor * self.standard_error / np.abs(self.inertance)

    def between(self, low: float, high: float) -> "FRF":
        """The bands from low to high [Hz], both included. Raises InputError when none is left."""
        kept = (self.frequency >= low - 1e-9) & (self.frequency <= high + 1e-9)
        if not kept.any():
            raise InputError(f"{self.name}: nothing between {low:g} and {high:g} Hz (measured: {self.frequency[0]:g} to {self.frequency[-1]:g} Hz)")
        arrays: dict[str, Any] = {key: value[kept] for key, value in vars(self).items() if isinstance(value, np.ndarray)}
        return replace(self, **arrays)


def band_width(recordings: Sequence[Recording]) -> float:
    """The width [Hz] of the bands that suits all of the recordings: a quarter of a hertz, more for short ones."""
    return max(NARROW, LINES / min(float(np.ptp(r.time)) for r in recordings))


def estimate(recording: Recording, reference: str = "", band: tuple[float, float] = (0.5, 12.0), width: float | None = None) -> FRF:
    """The inertance of one run, in bands of a width [Hz] whose centres go from one end of `band` [Hz] to the other.

    reference is one of REFERENCES: the commanded angle where it is logged, otherwise the measured one; the
    papers took the torque. Raises InputError for a recording that is too short or not excited.
    """
    reference = reference or next(r for r in REFERENCES if r in recording.columns or r == "steer_angle")
    if reference not in REFERENCES:
        raise unknown("reference", reference, REFERENCES)
    recording, notes = uniform(recording)
    duration = len(recording.time) / recording.rate
    width = width or band_width([recording])
    if duration < LINES / WIDE:
        raise InputError(f"{recording.name}: {duration:.3g} s are too short for a frequency response, at least {LINES / WIDE:g} s are needed")
    if width * duration < LINES * (1 - 1e-6):
        raise InputError(f"{recording.name}: {duration:.3g} s cannot give bands of {width:g} Hz, at least {LINES / duration:.3g} Hz are needed")
    frequencies = np.arange(band[0], min(band[1], 0.4 * recording.rate) + 1e-9, width)
    if not len(frequencies):
        raise InputError(f"{recording.name}: sampled at {recording.rate:.4g} Hz, nothing from {band[0]:g} to {band[1]:g} Hz can be measured; "
                         "is the time in the unit that the file says?")  # fmt: skip
    angle, torque, r = (spectrum(recording[c]) for c in ("steer_angle", "steer_torque", reference))
    grid = np.fft.rfftfreq(len(recording.time), 1 / recording.rate)
    bands = [np.flatnonzero(np.abs(grid - f) < width / 2) for f in frequencies]
    power = np.cumsum(np.abs(angle) ** 2 * (grid > NARROW))
    strongest = np.max(power[round(width * duration) :] - power[: -round(width * duration)])
    excited = [len(k) > 4 + LEAKAGE_TERMS and power[k[-1]] - power[k[0]] > EMPTY * strongest for k in bands]
    used = np.flatnonzero(excited)
    if not len(used):
        raise InputError(f"{recording.name}: nothing was excited between {band[0]:g} and {band[1]:g} Hz")
    acceleration = -((2 * pi * grid) ** 2) * angle
    columns = [band_average(grid[bands[i]], frequencies[i], width, acceleration[bands[i]], torque[bands[i]], r[bands[i]]) for i in used]
    apparent, variance, coherence, weights = (np.array(c) for c in zip(*columns, strict=True))
    frequency = np.asarray(frequencies, float)[used]
    none = np.full(len(used), np.nan)
    frf = FRF(recording.name, frequency, 1 / apparent, variance, coherence, frequency[:, None] + NODES * width / 2, weights,
              none, none, np.ones(len(used)), reference, recording.warnings + notes)  # fmt: skip
    return replace(frf, warnings=frf.warnings + _doubts(frf))


def spectrum(values: np.ndarray) -> np.ndarray:
    """The spectrum of a whole record without its mean, at the lines of numpy's rfftfreq."""
    return rfft(values - values.mean())


def band_average(grid, centre, width, acceleration, torque, reference):
    """(apparent inertia, its variance, coherence, weights at the nodes) of one band.

    grid (m,) [Hz] and the spectra (m,) of the band's lines; any ratio torque / acceleration of two spectra.
    """
    place = (grid - centre) / (width / 2)
    leakage, _ = np.linalg.qr(legvander(place, LEAKAGE_TERMS - 1))
    r = reference - leakage @ (leakage.T @ reference)
    cross = np.vdot(r, acceleration)
    shares = acceleration * r.conj() / cross
    apparent = np.vdot(r, torque) / cross
    # What is left when A may be a parabola within the band is noise.
    regressors = np.column_stack([acceleration, place * acceleration, place**2 * acceleration, leakage])
    residual = torque - regressors @ np.linalg.lstsq(regressors, torque)[0]
    noise = np.sum(np.abs(residual) ** 2) / (len(grid) - regressors.shape[1])
    signal = np.sum(np.abs(torque - leakage @ (leakage.T @ torque)) ** 2)
    variance = noise * np.sum(np.abs(r) ** 2) / abs(cross) ** 2
    moments = np.vander(place, len(NODES), increasing=True).T @ shares
    weights = np.linalg.solve(np.vander(NODES, increasing=True).T, moments)
    return apparent, variance, 1 - np.sum(np.abs(residual) ** 2) / signal, weights


def _doubts(frf: FRF) -> tuple[str, ...]:
    """What the FRF shows to be wrong with the channels.

    A passive rider on a handlebar takes power in at every frequency: the impedance's real part is positive.
    """
    found = []
    active = np.real(frf.impedance) < -3 * np.sqrt(frf.variance) * frf.omega
    if np.mean(active) > 0.5:
        found.append("power flows out of the rider at most frequencies: is the sign of torque or angle flipped?")
    if np.median(frf.coherence) < 0.5:
        found.append(f"median coherence {np.median(frf.coherence):.2f}: are these the right channels?")
    return tuple(found)


def mean_frf(frfs: Sequence[FRF], name: str = "mean") -> FRF:
    """The mean of several FRFs, of modulus and phase each (as both papers take it), with their deviations.

    The mean rider is identified from this, not from averaged parameters. One FRF is its own mean.
    """
    if len(frfs) == 1:
        return frfs[0]
    frequency = np.unique(np.round(np.concatenate([f.frequency for f in frfs]), 9))

    def table(values: Callable[[FRF], np.ndarray]) -> np.ndarray:
        rows = np.full((len(frfs), len(frequency)), np.nan, complex)
        for row, frf in zip(rows, frfs, strict=True):
            row[np.searchsorted(frequency, np.round(frf.frequency, 9))] = values(frf)
        return rows

    inertance = table(lambda f: f.inertance)
    here = ~np.isnan(inertance)
    runs = here.sum(axis=0)
    direction = np.nansum(np.exp(1j * np.angle(inertance)), axis=0)
    turn = np.angle(inertance / direction)  # phases around their mean direction, where none of them wraps
    modulus, phase = np.nanmean(np.abs(inertance), axis=0), np.angle(direction) + np.nanmean(turn, axis=0)
    mean = modulus * np.exp(1j * phase)

    def deviation(values: np.ndarray) -> np.ndarray:
        squares = np.nansum((values - np.nanmean(values, axis=0)) ** 2, axis=0)
        return np.where(runs > 1, np.sqrt(squares / np.maximum(runs - 1, 1)), np.nan)

    own = np.nansum(np.abs(table(lambda f: np.sqrt(f.variance))) ** 2, axis=0) / runs**2
    spread = (deviation(np.abs(inertance)) ** 2 + (modulus * deviation(turn)) ** 2) / modulus**4 / runs
    return FRF(name, frequency, mean, np.fmax(own, spread), np.real(np.nanmean(table(lambda f: f.coherence), axis=0)),
               frequency[:, None] + 0 * NODES, np.tile(CENTRE, (len(frequency), 1)),
               deviation(np.abs(inertance)), deviation(turn), runs, frfs[0].reference,
               tuple(f"{f.name}: {w}" for f in frfs for w in f.warnings))  # fmt: skip


def exact_frf(frequency: np.ndarray, inertance: np.ndarray, name: str = "exact") -> FRF:
    """An FRF that was not estimated: one from a model, from a paper's figure, or from another program.

    frequency (n,) [Hz], inertance (n,) complex [(rad/s2)/(N.m)]; all points weigh the same.
    """
    frequency, inertance = np.asarray(frequency, float), np.asarray(inertance, complex)
    ones, none = np.ones(len(frequency)), np.full(len(frequency), np.nan)
    return FRF(name, frequency, inertance, np.abs(1 / inertance) ** 2 * 1e-4, ones, frequency[:, None] + 0 * NODES,
               np.tile(CENTRE, (len(frequency), 1)), none, none, ones)  # fmt: skip
