"""What was told to a component, at any time: recorded inputs between their samples, an imposed motion with its rates.

An input is held, joined by lines, or joined smoothly; where it is rough these differ by a lag of up to half a sample,
which a fit would take for a delay. A held input is, up to half of the sampling rate, lines through sharper samples
half a sample later. An imposed motion is a spline whose knots are as far apart as its spectrum allows: its noise would
become force otherwise. What noise is left in it must not explain the noise of the force: for that there is the motion without it.
How much is not known between the samples shows in the difference of two splines.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline, make_lsq_spline
from scipy.signal import periodogram

KEPT = 32  # sets of times of which the values are kept
KINDS = ("smooth", "lines", "held")
SMOOTHER = "smoother"
NOISELESS = "noiseless"
CLEAR = 10.0  # times its noise, in power: where a motion stands clear of it
ROUGH = 0.02  # share of an input's power in the upper half of its spectrum, from which the kinds differ
DEGREE = 5
AREA = float(np.sqrt(9 / 5 / 12))
LEAST_POWER = 1e-6  # of a signal's power: what lies above is of no interest
PER_PERIOD = 6.0  # knots per period of the highest frequency: with fewer a spline's acceleration is too small
CLOSEST = 3  # samples between the knots of an imposed motion


@dataclass
class Told:
    """Functions of time by name; called with times (n,) it gives their values (n,) by name. The last few are kept."""

    functions: Mapping[str, Callable[[np.ndarray], np.ndarray]]
    ends: tuple[float, float]
    known: dict = field(default_factory=dict)

    def scaled(self, factor: float) -> "Told":
        """Everything times a factor."""
        return Told({name: _times(factor, function) for name, function in self.functions.items()}, self.ends)

    def __call__(self, time: np.ndarray) -> dict[str, np.ndarray]:
        key = hash(time.tobytes())
        if key not in self.known:
            if len(self.known) > KEPT:
                self.known.clear()
            inside = np.clip(time, *self.ends)
            self.known[key] = {name: function(inside) for name, function in self.functions.items()}
        return self.known[key]


def _times(factor: float, function: Callable[[np.ndarray], np.ndarray]) -> Callable[[np.ndarray], np.ndarray]:
    return lambda time: factor * function(time)


def input_function(time: np.ndarray, values: np.ndarray, kind: str) -> Callable[[np.ndarray], np.ndarray]:
    """The input between its samples (n,)."""
    if kind in ("smooth", NOISELESS):
        return CubicSpline(time, values)
    if kind == SMOOTHER:
        return make_interp_spline(time, values + unforeseen(values), DEGREE)
    if kind == "lines":
        return lambda t: np.interp(t, time, values)
    late, sharp = (time[1] - time[0]) / 2, _sharpened(values)
    return lambda t: np.interp(t - late, time, sharp)


def _sharpened(values: np.ndarray) -> np.ndarray:
    """Samples (n,) that, joined by lines, have the spectrum of the held ones: holding multiplies it by sinc(f T), lines by its square."""
    n = len(values)
    mirrored = np.concatenate([values, values[::-1]])
    return np.fft.irfft(np.fft.rfft(mirrored) / np.sinc(np.fft.rfftfreq(2 * n)), 2 * n)[:n]


def unforeseen(values: np.ndarray) -> np.ndarray:
    """What may be missed of an input's area by its samples (n,), at each of them and in random directions, in the input's unit.

        e4_k = d^4 u_k / 6,  e6_k = d^6 u_k / 20      u_k less what its 4, or 6, neighbours let expect
        deviation = AREA |e4_k| min(1, sum e6^2 / sum e4^2)

    A jump lies anywhere between two samples: of its area J h / sqrt(12) is not known, and sum e4^2 is 5 J^2 / 9. What is
    smooth is expected the better, the more neighbours are asked.
    """
    middle = slice(3, -3)
    by_four, by_six = np.zeros(len(values)), np.diff(values, 6) / 20
    by_four[2:-2] = np.diff(values, 4) / 6
    power = float(np.sum(by_four[middle] ** 2))
    alike = min(1.0, float(np.sum(by_six**2)) / power) if power > 0 else 0.0
    return AREA * alike * by_four * np.random.default_rng(0).choice([-1.0, 1.0], len(values))


def is_rough(values: np.ndarray) -> bool:
    """Whether an input (n,) has so much power near the sampling rate that it matters how its samples are joined."""
    _, power = periodogram(values - values.mean())
    return float(power[len(power) // 2 :].sum()) > ROUGH * float(power.sum())


def motion_functions(time: np.ndarray, values: np.ndarray, rate: str, kind: str = KINDS[0]) -> dict[str, Callable]:
    """An imposed motion's rate and acceleration beside it: names "", rate and der(rate)."""
    values = _without_noise(values) if kind == NOISELESS else values
    spline = make_lsq_spline(time, values, _knots(time, values, PER_PERIOD * (1.5 if kind == SMOOTHER else 1.0)), DEGREE)
    return {"": spline, rate: spline.derivative(1), f"der({rate})": spline.derivative(2)}


def _knots(time: np.ndarray, values: np.ndarray, per_period: float) -> np.ndarray:
    """Knots close enough for the highest frequency that the motion has beyond its noise."""
    step = time[1] - time[0]
    highest = highest_frequency(values, 1 / step)
    apart = max(int(1 / (per_period * highest * step)), CLOSEST)
    inner = time[apart : -max(apart, DEGREE + 1) : apart]
    return np.concatenate([[time[0]] * (DEGREE + 1), inner, [time[-1]] * (DEGREE + 1)])


def _without_noise(values: np.ndarray) -> np.ndarray:
    """A motion (n,) without the frequencies at which it does not stand clear of its noise."""
    n = len(values)
    line = np.interp(np.arange(n), [0, n - 1], values[[0, -1]])
    _, power, floor = _smooth_spectrum(values, 1.0)
    return line + np.fft.irfft(np.where(power > CLEAR * floor, np.fft.rfft(values - line), 0.0), n)


def highest_frequency(values: np.ndarray, rate: float, share: float = 4.0) -> float:
    """The highest frequency [Hz] at which a signal (n,) stands out from what it has at the highest ones.

    What is above it in power by less than a millionth is left to itself: no model is better than that.
    """
    frequency, power, floor = _smooth_spectrum(values, rate)
    beyond = np.cumsum(power[::-1])[::-1] / power.sum()
    above = np.flatnonzero((power > share * floor) & (beyond > LEAST_POWER))
    return float(frequency[above[-1]]) if len(above) else float(frequency[-1] / 2)


def _smooth_spectrum(values: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Frequencies (m,), the smoothed power of a signal (n,) at them, and that which it has at the highest ones."""
    n = len(values)
    line = np.interp(np.arange(n), [0, n - 1], values[[0, -1]])
    frequency, power = periodogram((values - line) * np.hanning(n), rate)
    width = max(n // 400, 5)
    smooth = np.convolve(power, np.ones(width) / width, "same")
    return frequency, smooth, float(np.median(smooth[int(0.7 * len(smooth)) :]))
