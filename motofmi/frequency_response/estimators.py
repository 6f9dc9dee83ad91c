"""Inertances from recordings, by band averages of the whole record's spectra.

    inertance H = S_ar / S_Mr,     a = -omega^2 delta

a is the angular acceleration of the handlebar, M the torque, and r the reference of the cross-spectra:
  - the torque itself: S_aM / S_MM, the estimator of both papers. The rider's own torque noise is in S_MM,
    so the estimate is too small if the rider is not passive;
  - the steer angle, which the servo imposes: S_aa / S_Ma, unbiased by noise in the torque;
  - the commanded angle, if the rig records it: unbiased by noise in the angle too.

A record with gaps is taken as the stretches between them. In each band

    M_k = A(f_k) a_k + p_s(f_k) + noise,     A = M/a = A_0 + A_1 f + A_2 f^2,     k: all lines of all stretches s

where the polynomial p_s is the leakage from the ends of stretch s into its spectrum. It is removed from r, so that
starts, ends and cuts cause no bias (the local polynomial method: Pintelon, Schoukens, System Identification, 2nd ed.,
ch. 7; for several stretches: Schoukens, Vandersteen, Rolain, Pintelon, Frequency response function measurements using
concatenated subrecords with arbitrary length, IEEE Transactions on Instrumentation and Measurement, 2012).

The estimate is a weighted mean of the apparent inertia over the band, A_band = sum w_k A(f_k). The FRF holds the
weights w_k, so that a model is averaged in the same way before it is compared.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np
from numpy.polynomial.legendre import legvander
from scipy.fft import rfft, rfftfreq

from fmus.support.errors import InputError, unknown
from motofmi.frequency_response.frf import FRF, NODES
from motofmi.recordings.channels import STEER_ANGLE, STEER_ANGLE_COMMAND, STEER_TORQUE
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import uniform

REFERENCES = (STEER_ANGLE_COMMAND, STEER_ANGLE, STEER_TORQUE)
LEAKAGE_TERMS = 2  # coefficients of the polynomial in frequency by which the ends of each stretch enter a band
INERTIA_TERMS = 3  # coefficients of the apparent inertia within a band; the deviation from a parabola counts as noise
LINES = 12  # least number of spectral lines in a band
NARROW, WIDE = 0.25, 2.0  # Hz; default and largest width of a band
EMPTY = 0.01  # least excitation of a band, as a share of the strongest band's
# Records with gaps: in a study of 5872 bands (sweeps either way and stepped sines, one to twenty gaps), errors beyond
# three standard errors came with 29 % of the bands that keep less than KEPT of the reference's power when leakage is
# taken out, with 4 % of those of three lines, and with none of the others.
KEPT = 0.03
FEWEST = 4  # least number of lines of a stretch in a band
LISTED = 8  # largest number of frequencies without an estimate that a warning lists


@dataclass(frozen=True)
class Spectra:
    """Spectra of channels over the m lines of all stretches of a record, by rising frequency.

    frequency (m,) [Hz]; stretch (m,) the number of the stretch that a line belongs to; values: channel -> (m,)
    complex, scaled so that white noise has the same power in lines of long and short stretches; duration [s] of
    all stretches together.
    """

    frequency: np.ndarray
    stretch: np.ndarray
    values: dict[str, np.ndarray]
    duration: float

    def near(self, centre: float, width: float) -> np.ndarray:
        """The places of the lines in the band of a width [Hz] around its centre [Hz]."""
        return np.flatnonzero(np.abs(self.frequency - centre) < width / 2)


def spectra(recording: Recording, channels: Iterable[str]) -> Spectra:
    """The spectra of the stretches without gaps of a recording on a regular grid, each without its mean."""
    stretches = recording.stretches
    grids = [rfftfreq(s.stop - s.start, 1 / recording.rate) for s in stretches]
    frequency = np.concatenate(grids)
    order = np.argsort(frequency, kind="stable")
    number = np.repeat(np.arange(len(stretches)), [len(grid) for grid in grids])
    values = {name: np.concatenate([_scaled(recording[name][s]) for s in stretches])[order] for name in channels}
    return Spectra(frequency[order], number[order], values, sum(s.stop - s.start for s in stretches) / recording.rate)


def _scaled(values: np.ndarray) -> np.ndarray:
    return rfft(values - values.mean()) / np.sqrt(len(values))


def band_width(recordings: Sequence[Recording]) -> float:
    """The width [Hz] of the bands that suits all of the recordings: a quarter of a hertz, more for short ones."""
    return max(NARROW, LINES / min(float(np.ptp(r.time)) for r in recordings))


def estimate(
    recording: Recording, reference: str = "", band: tuple[float, float] = (0.5, 12.0), width: float | None = None
) -> FRF:
    """The inertance of one run, in bands of a width [Hz] whose centres go from one end of `band` [Hz] to the other.

    reference is one of REFERENCES: the commanded angle where it is logged, otherwise the measured one; the
    papers use the torque. Raises InputError for a recording that is too short or not excited.
    """
    reference = reference or next(r for r in REFERENCES if r in recording.columns or r == STEER_ANGLE)
    if reference not in REFERENCES:
        raise unknown("reference", reference, REFERENCES)
    recording, notes = uniform(recording)
    width = width or band_width([recording])
    centres = _centres(recording, band, width)
    lines = spectra(recording, {STEER_ANGLE, STEER_TORQUE, reference})
    angle, grid = lines.values[STEER_ANGLE], lines.frequency
    bands, frequency, lost = _measurable(lines, centres, width, angle, lines.values[reference])
    gaps = _gap_warnings(recording, width, lost)
    if not bands:
        if len(lost):
            raise InputError(
                f"{recording.name}: {gaps[0]}, none long enough for bands of {width:g} Hz; give wider bands"
            )
        raise InputError(f"{recording.name}: nothing was excited between {band[0]:g} and {band[1]:g} Hz")
    acceleration = -((2 * pi * grid) ** 2) * angle
    columns = [band_average((grid[k] - f) / (width / 2), lines.stretch[k], acceleration[k],
                            lines.values[STEER_TORQUE][k], lines.values[reference][k])
               for k, f in zip(bands, frequency, strict=True)]  # fmt: skip
    apparent, variance, coherence, weights = (np.array(c) for c in zip(*columns, strict=True))
    none = np.full(len(frequency), np.nan)
    frf = FRF(recording.name, frequency, 1 / apparent, variance, coherence, frequency[:, None] + NODES * width / 2,
              weights, none, none, np.ones(len(frequency)), reference, recording.warnings + notes + gaps)  # fmt: skip
    return replace(frf, warnings=frf.warnings + _warnings(frf))


def _centres(recording: Recording, band: tuple[float, float], width: float) -> np.ndarray:
    """The centres (n,) [Hz] of bands of a width [Hz]. Raises InputError where the recording is too short
    or too slow for them."""
    duration = len(recording.time) / recording.rate
    if duration < LINES / WIDE:
        raise InputError(
            f"{recording.name}: {duration:.3g} s are too short for a frequency response, at least {LINES / WIDE:g} s "
            "are needed"
        )
    if width * duration < LINES * (1 - 1e-6):
        raise InputError(
            f"{recording.name}: {duration:.3g} s cannot give bands of {width:g} Hz, at least {LINES / duration:.3g} Hz "
            "are needed"
        )
    centres = np.arange(band[0], min(band[1], 0.4 * recording.rate) + 1e-9, width)
    if not len(centres):
        raise InputError(f"{recording.name}: sampled at {recording.rate:.4g} Hz, nothing from {band[0]:g} to "
                         f"{band[1]:g} Hz can be measured; is the time in the unit that the file says?")  # fmt: skip
    return centres


def _measurable(lines: Spectra, centres: np.ndarray, width: float, angle: np.ndarray,
                reference: np.ndarray) -> tuple[list[np.ndarray], np.ndarray, np.ndarray]:  # fmt: skip
    """The lines of each band that holds a measurement, the centres of these bands, and those that
    are lost to gaps [Hz].

    An excitation within 1/width [s] of a gap has as smooth a spectrum as the leakage of the gap.
    """
    power = np.cumsum(np.abs(angle) ** 2 * (lines.frequency > NARROW))
    many = round(width * lines.duration)
    strongest = np.max(power[many:] - power[:-many])
    bands, found, lost, gaps = [], [], [], lines.stretch.any()
    for centre in centres:
        k = lines.near(centre, width)
        if len(k) <= INERTIA_TERMS + LEAKAGE_TERMS + 1 or power[k[-1]] - power[k[0]] <= EMPTY * strongest:
            continue
        if gaps:
            near, k = k, k[np.bincount(lines.stretch[k])[lines.stretch[k]] >= FEWEST]
            r = reference[k]
            leaked = _leakage((lines.frequency[k] - centre) / (width / 2), lines.stretch[k]).T @ r
            kept = np.sum(np.abs(r) ** 2) - np.sum(np.abs(leaked) ** 2)
            if _freedom(lines.stretch[k]) < 2 or kept < KEPT * np.sum(np.abs(reference[near]) ** 2):
                lost.append(centre)
                continue
        bands.append(k)
        found.append(centre)
    return bands, np.array(found), np.array(lost)


def _gap_warnings(recording: Recording, width: float, lost: np.ndarray) -> tuple[str, ...]:
    """Warnings about the parts of a record with gaps that are not used; lost (k,) are the frequencies [Hz] of the bands
    without an estimate."""
    if not recording.gaps:
        return ()
    count = len(recording.gaps)
    left = (f"{count} gap{'s are' if count > 1 else ' is'} left out, the first at {recording.gaps[0][0]:g} s: "
            f"the spectra are of the {len(recording.stretches)} stretches between")  # fmt: skip
    if not len(lost):
        return (left,)
    where = (
        ", ".join(f"{f:g}" for f in lost)
        if len(lost) <= LISTED
        else f"{len(lost)} frequencies from {lost[0]:g} to {lost[-1]:g}"
    )
    return (
        left,
        f"no estimate at {where} Hz: what was excited there is within {1 / width:g} s of a gap; wider bands come "
        "nearer",
    )


def band_average(place: np.ndarray, stretch: np.ndarray, acceleration: np.ndarray, torque: np.ndarray,
                 reference: np.ndarray) -> tuple[complex, float, float, np.ndarray]:  # fmt: skip
    """(apparent inertia, its variance, coherence, weights at the nodes) of one band.

    place (m,) of the band's lines from -1 to 1, stretch (m,) of each line, and the spectra (m,); any ratio
    torque / acceleration.
    """
    leakage = _leakage(place, stretch)
    r = reference - leakage @ (leakage.T @ reference)
    cross = np.vdot(r, acceleration)
    shares = acceleration * r.conj() / cross
    apparent = np.vdot(r, torque) / cross
    regressors = np.column_stack([*(place**power * acceleration for power in range(INERTIA_TERMS)), leakage])
    residual = torque - regressors @ np.linalg.lstsq(regressors, torque)[0]
    noise = np.sum(np.abs(residual) ** 2) / _freedom(stretch)
    signal = np.sum(np.abs(torque - leakage @ (leakage.T @ torque)) ** 2)
    variance = noise * np.sum(np.abs(r) ** 2) / abs(cross) ** 2
    moments = np.vander(place, len(NODES), increasing=True).T @ shares
    weights = np.linalg.solve(np.vander(NODES, increasing=True).T, moments)
    return apparent, variance, 1 - np.sum(np.abs(residual) ** 2) / signal, weights


def _leakage(place: np.ndarray, stretch: np.ndarray) -> np.ndarray:
    """Orthonormal polynomials (m, k) in the place (m,) of a line, of their own for each stretch."""
    blocks = [np.empty((len(place), 0))]
    for number in np.flatnonzero(np.bincount(stretch)):
        own = np.flatnonzero(stretch == number)
        basis, _ = np.linalg.qr(legvander(place[own], LEAKAGE_TERMS - 1))
        blocks.append(np.zeros((len(place), basis.shape[1])))
        blocks[-1][own] = basis
    return np.concatenate(blocks, axis=1)


def _freedom(stretch: np.ndarray) -> int:
    """The complex degrees of freedom that the lines of a band leave for the noise; stretch (m,) of each line."""
    return len(stretch) - INERTIA_TERMS - int(np.sum(np.minimum(np.bincount(stretch), LEAKAGE_TERMS)))


def _warnings(frf: FRF) -> tuple[str, ...]:
    """Warnings about channels that the FRF shows to be wrong.

    A passive rider on a handlebar dissipates power at every frequency: the impedance's real part is positive.
    """
    found = []
    active = np.real(frf.impedance) < -3 * np.sqrt(frf.variance) * frf.omega
    if np.mean(active) > 0.5:
        found.append("power flows out of the rider at most frequencies: is the sign of torque or angle flipped?")
    if np.median(frf.coherence) < 0.5:
        found.append(f"median coherence {np.median(frf.coherence):.2f}: are these the right channels?")
    return tuple(found)
