"""The roll test of 2008: transfer functions of the measured points, and the features that the paper prints of them.

    FRF_i = a_i / (alpha h_i),      rFRF_i = FRF_i - 1

Source: Cossalter, Doria, Fabris, Maso, Measurement and identification of the vibration characteristics of
motorcycle riders (2008), Sect. 4: roll amplitude 1 deg, 0.5 to 7 Hz in steps of 0.25 Hz, figures 16 to 23.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fmus.declaration.component import Component
from fmus.linear_analysis.linearisation import linearise
from rider_fmu.components.rider_in_roll import POINTS, point_heights

FREQUENCIES = np.arange(0.5, 7.01, 0.25)  # Hz
HIGH = 4.0  # Hz: "high frequency" where the paper gives no number
RIDERS = (1, 2, 3)  # of the roll test; "similar results can be obtained" for the others where rider 3's are shown
NUMBER = {"waist": 2, "shoulder": 3, "head": 4}

Curves = dict[str, np.ndarray]


def roll_frf(rider: Component, frequency: np.ndarray = FREQUENCIES) -> Curves:
    """FRF of every point (n,), complex, from the linearised component; frequency (n,) in Hz."""
    omega = 2 * np.pi * np.asarray(frequency, float)
    space = linearise(rider)
    heights = point_heights(rider)
    found = {}
    for point in POINTS:
        to_angle, to_rate = (
            space.frequency_response(omega, f"{point}_velocity", name) for name in ("roll_angle", "roll_rate")
        )
        velocity = to_angle + 1j * omega * to_rate
        found[point] = 1j * omega * velocity / (-(omega**2) * heights[point])
    return found


def relative(curves: Curves) -> Curves:
    """rFRF of every point."""
    return {point: curve - 1 for point, curve in curves.items()}


@dataclass(frozen=True)
class Feature:
    """A published feature: its range [low, high], the function that reads its least and largest value off a curve,
    its riders.
    """

    quantity: str
    point: str
    name: str
    low: float
    high: float
    unit: str
    read: Callable[[np.ndarray, np.ndarray], tuple[float, float]]
    riders: tuple[int, ...] = RIDERS


def _peak(f, c):
    at = float(f[np.argmax(np.abs(c))])
    return at, at


def _first_lag(f, c):
    lag = float(-np.degrees(np.angle(c[0])))
    return lag, lag


def _rises_above_peak(f, c):
    """The largest rise of the modulus from one frequency to the next above its peak; 0 when it only falls."""
    modulus = np.abs(c)[np.argmax(np.abs(c)) :]
    return 0.0, float(max(np.diff(modulus).max(initial=0.0), 0.0))


def _peaks(f, c):
    """How many local maxima of the modulus lie below 2 Hz."""
    modulus = np.abs(c)
    inner = (modulus[1:-1] > modulus[:-2]) & (modulus[1:-1] > modulus[2:]) & (f[1:-1] < 2)
    return float(inner.sum()), float(inner.sum())


def _modulus(above: float):
    def read(f, c):
        part = np.abs(c)[f > above]
        return float(part.min()), float(part.max())

    return read


def _phase(f, c):
    """Degrees between -360 and 0."""
    part = -np.degrees(np.mod(-np.angle(c[f > HIGH]), 2 * np.pi))
    return float(part.min()), float(part.max())


FEATURES = (
    Feature("FRF", "waist", "peak_frequency", 0.75, 1.25, "Hz", _peak),
    Feature("FRF", "waist", "phase_lag_at_lowest_frequency", 0, 45, "deg", _first_lag),
    Feature("FRF", "waist", "monotonic_decrease_above_peak", 0, 0, "1", _rises_above_peak),
    Feature("FRF", "shoulder", "peak_frequency", 0.75, 1.25, "Hz", _peak),
    Feature("FRF", "shoulder", "modulus_at_high_frequency", 0.1, 0.2, "1", _modulus(HIGH)),
    Feature("FRF", "head", "peaks_below", 2, 2, "1", _peaks),
    Feature("FRF", "head", "modulus_at_high_frequency", 0, 0.1, "1", _modulus(HIGH), (1, 3)),
    Feature("rFRF", "waist", "modulus_above_2Hz", 1.0, 1.2, "1", _modulus(2.0)),
    Feature("rFRF", "shoulder", "modulus_above_2Hz", 1.0, 1.2, "1", _modulus(2.0)),
    Feature("rFRF", "head", "peak_frequency", 1.0, 1.5, "Hz", _peak),
    Feature("rFRF", "head", "modulus_above_2Hz", 0.9, 1.1, "1", _modulus(2.0)),
    Feature("rFRF", "waist", "phase_at_high_frequency", -190, -150, "deg", _phase),
    Feature("rFRF", "shoulder", "phase_at_high_frequency", -190, -150, "deg", _phase),
    Feature("rFRF", "head", "phase_at_high_frequency", -190, -150, "deg", _phase),
)


def readings(curves: Curves, frequency: np.ndarray = FREQUENCIES) -> list[tuple[float, float]]:
    """The least and largest value of every feature, in the order of FEATURES."""
    tables = {"FRF": curves, "rFRF": relative(curves)}
    return [feature.read(frequency, tables[feature.quantity][feature.point]) for feature in FEATURES]


def misses(curves: Curves, frequency: np.ndarray = FREQUENCIES) -> np.ndarray:
    """The distance of each feature to its range (14,), in widths of the range (in the unit of the feature where that
    is zero).
    """
    found = []
    for feature, (low, high) in zip(FEATURES, readings(curves, frequency), strict=True):
        width = feature.high - feature.low or 1.0
        found.append(max(feature.low - low, high - feature.high, 0.0) / width)
    return np.array(found)
