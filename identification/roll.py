"""The roll test: how the rider's body follows the rolling mock-up.

    FRF_i = a_i / (alpha h_i) = a_i h_1 / (a_1 h_i),     rFRF_i = FRF_i - 1

a_1 is the tangential acceleration of the mock-up at the distance h_1 from the roll axis, a_i that of the
rider's body at h_i: waist, shoulders and head are points 2, 3 and 4.

Source: Cossalter, Doria, Fabris, Maso (2008), Sect. 4, eqs 6 to 12; the published features of the FRFs.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fmus.errors import InputError
from identification.frf import band_average, spectrum
from identification.recordings import Recording
from identification.sampling import uniform

POINTS = {"waist": 2, "shoulder": 3, "head": 4}
REFERENCE = "mockup_acceleration"
WIDTH = 0.15  # Hz around each frequency of the test
HIGH = 5.0  # Hz, where "high frequency" begins in a test up to 7 Hz


@dataclass(frozen=True)
class RollFRF:
    """frequency (n,) [Hz]; absolute: point -> FRF (n,) complex; relative: point -> rFRF (n,) complex."""

    frequency: np.ndarray
    absolute: dict[str, np.ndarray]

    @property
    def relative(self) -> dict[str, np.ndarray]:
        return {point: frf - 1 for point, frf in self.absolute.items()}


def roll_frf(recording: Recording, heights: Mapping[str, float], frequencies: np.ndarray) -> RollFRF:
    """The FRFs of a test with single frequencies [Hz], in any order; heights [m] of mockup, waist, shoulder, head.

    Raises InputError for a missing height or channel.
    """
    points = [point for point in POINTS if f"{point}_acceleration" in recording.columns]
    for point in ("mockup", *points):
        if not heights.get(point, 0) > 0:
            raise InputError(f"{recording.name}: the height of {point} above the roll axis is missing; "
                             f'give "{point}_height": {{"value": 1.0, "unit": "m"}} in rig.json')  # fmt: skip
    recording, _ = uniform(recording)
    grid = np.fft.rfftfreq(len(recording.time), 1 / recording.rate)
    mockup = spectrum(recording[REFERENCE])
    absolute = {}
    for point in points:
        body = spectrum(recording[f"{point}_acceleration"])
        bands = [(f, np.abs(grid - f) < WIDTH / 2) for f in frequencies]
        ratios = [band_average(grid[k], f, WIDTH, mockup[k], body[k], mockup[k])[0] for f, k in bands]
        absolute[point] = np.array(ratios) * heights["mockup"] / heights[point]
    return RollFRF(np.asarray(frequencies, float), absolute)


@dataclass(frozen=True)
class Feature:
    """A printed feature, what the measurement gives, and whether it is within the printed range."""

    quantity: str
    point: int
    feature: str
    printed: str
    value: float
    met: bool


def check_features(frf: RollFRF, features: list[dict[str, str]]) -> list[Feature]:
    """The published features (rows of quantity, point, feature, lo, hi, printed) against FRFs."""
    found = []
    for row in features:
        name = next(n for n, number in POINTS.items() if number == int(row["point"]))
        curve = (frf.absolute if row["quantity"] == "FRF" else frf.relative).get(name)
        if curve is None:
            continue
        low, high = (float(row[k]) if row[k] else np.nan for k in ("lo", "hi"))
        value, met = MEASURES[row["feature"]](frf.frequency, curve, low, high)
        found.append(Feature(row["quantity"], int(row["point"]), row["feature"], row["printed"], value, met))
    return found


def _peak_frequency(frequency, curve, low, high):
    at = float(frequency[np.argmax(np.abs(curve))])
    return at, low <= at <= high


def _phase_lag(frequency, curve, low, high):
    lag = -np.degrees(np.angle(curve))
    return float(lag[0]), bool(low <= lag[0] <= high and lag[1] > lag[0])


def _monotonic_decrease(frequency, curve, low, high):
    modulus = np.abs(curve)
    rise = float(np.max(np.diff(modulus[np.argmax(modulus) :]), initial=0.0))
    return rise, rise <= 0.0


def _modulus_at_high(frequency, curve, low, high):
    modulus = np.abs(curve[frequency >= HIGH])
    return float(modulus.mean()), bool(np.all((modulus >= low) & (modulus <= high)))


def _modulus_above_2_hz(frequency, curve, low, high):
    modulus = np.abs(curve[frequency > 2.0])
    return float(modulus[np.argmax(np.abs(modulus - (low + high) / 2))]), bool(np.all((modulus >= low) & (modulus <= high)))


def _peaks_below(frequency, curve, low, high):
    modulus = np.abs(curve)
    peaks = np.flatnonzero((modulus[1:-1] > modulus[:-2]) & (modulus[1:-1] > modulus[2:])) + 1
    below = np.count_nonzero(frequency[peaks] < high)
    return float(below), bool(below == 2 and frequency[np.argmax(modulus)] < high)


def _phase_at_high(frequency, curve, low, high):
    phase = np.degrees(np.angle(curve[frequency >= HIGH]))
    phase = np.where(phase > 0, phase - 360, phase)
    return float(phase.mean()), bool(np.all((phase >= low) & (phase <= high)))


MEASURES = {
    "peak_frequency": _peak_frequency,
    "phase_lag_at_lowest_frequency": _phase_lag,
    "monotonic_decrease_above_peak": _monotonic_decrease,
    "modulus_at_high_frequency": _modulus_at_high,
    "modulus_above_2Hz": _modulus_above_2_hz,
    "peaks_below": _peaks_below,
    "phase_at_high_frequency": _phase_at_high,
}
