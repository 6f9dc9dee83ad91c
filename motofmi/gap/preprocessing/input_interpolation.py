"""Recorded inputs as functions of time, and an imposed motion with its rate and acceleration.

Between its samples an input is held, linear or smooth. For rough inputs these differ by a delay of up to half a
sample, which a fit would take for a delay of the component. Up to half the sampling rate, a held input equals lines
through sharpened samples, half a sample later. An imposed motion is a spline with knots as far apart as the
frequency allows up to which the motion exceeds its noise, since noise would become force otherwise. The remaining noise
of the motion must not explain the noise of the force, so a version without it is used there. The difference between two
splines shows how well the input is known between its samples.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline, make_lsq_spline
from scipy.signal import periodogram

CACHED = 32  # sets of times whose values are cached
KINDS = ("smooth", "lines", "held")
SMOOTHER = "smoother"
NOISELESS = "noiseless"
ABOVE_NOISE = 10.0  # ratio of power to noise power above which a motion is resolved
TINY = 1e-300  # of a power, whose logarithm is taken
ROUGH = 0.02  # share of an input's power in the upper half of its spectrum from which the interpolations differ
DEGREE = 5  # of splines: the acceleration is then smooth
AREA = float(np.sqrt(9 / 5 / 12))  # see `unresolved_input`
LEAST_POWER = 1e-6  # share of a signal's power above the highest frequency that is considered
PER_PERIOD = 6.0  # knots per period of the highest frequency: with fewer a spline's acceleration is too small
LEAST_PER_PERIOD = 3.0  # knots per period with which a spline's acceleration is right within 7 % (0.2 % with 6)
CLOSEST = 2.0  # samples between the knots of an imposed motion


@dataclass
class InterpolatedInputs:
    """Functions of time by name; a call with times (n,) gives their values (n,) by name and caches them."""

    functions: Mapping[str, Callable[[np.ndarray], np.ndarray]]
    ends: tuple[float, float]
    known: dict = field(default_factory=dict)

    def scaled(self, factor: float) -> "InterpolatedInputs":
        """All inputs times a factor."""
        return InterpolatedInputs(
            {name: _times(factor, function) for name, function in self.functions.items()}, self.ends
        )

    def __call__(self, time: np.ndarray) -> dict[str, np.ndarray]:
        key = hash(time.tobytes())
        if key not in self.known:
            if len(self.known) > CACHED:
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
        return make_interp_spline(time, values + unresolved_input(values), DEGREE)
    if kind == "lines":
        return lambda t: np.interp(t, time, values)
    late, sharp = (time[1] - time[0]) / 2, _sharpened(values)
    return lambda t: np.interp(t - late, time, sharp)


def _sharpened(values: np.ndarray) -> np.ndarray:
    """Samples (n,) whose linear interpolation has the spectrum of the held ones: holding multiplies it by sinc(f T),
    lines by its square."""
    n = len(values)
    mirrored = np.concatenate([values, values[::-1]])
    return np.fft.irfft(np.fft.rfft(mirrored) / np.sinc(np.fft.rfftfreq(2 * n)), 2 * n)[:n]


def unresolved_input(values: np.ndarray) -> np.ndarray:
    """The part of an input's time integral that its samples (n,) do not resolve, per sample, with random
    sign, in the input's unit.

        e4_k = d^4 u_k / 6,  e6_k = d^6 u_k / 20      error of predicting u_k from its 4, or 6, neighbours
        deviation = AREA |e4_k| min(1, sum e6^2 / sum e4^2)

    A jump J lies anywhere between two samples: its time integral is uncertain by J h / sqrt(12), and sum e4^2 is 5 J^2
    / 9. For a smooth input the prediction error decreases with the number of neighbours.
    """
    middle = slice(3, -3)
    by_four, by_six = np.zeros(len(values)), np.diff(values, 6) / 20
    by_four[2:-2] = np.diff(values, 4) / 6
    power = float(np.sum(by_four[middle] ** 2))
    alike = min(1.0, float(np.sum(by_six**2)) / power) if power > 0 else 0.0
    return AREA * alike * by_four * np.random.default_rng(0).choice([-1.0, 1.0], len(values))


def is_rough(values: np.ndarray) -> bool:
    """Whether an input (n,) has so much power near half the sampling rate that its interpolation matters."""
    _, power = periodogram(values - values.mean())
    return float(power[len(power) // 2 :].sum()) > ROUGH * float(power.sum())


def motion_functions(time: np.ndarray, values: np.ndarray, rate: str, kind: str = KINDS[0]) -> dict[str, Callable]:
    """An imposed motion, its rate and its acceleration, under the names "", rate and der(rate)."""
    values = _without_noise(values) if kind == NOISELESS else values
    spline = make_lsq_spline(time, values, _knots(time, values, 1.5 if kind == SMOOTHER else 1.0), DEGREE)
    return {"": spline, rate: spline.derivative(1), f"der({rate})": spline.derivative(2)}


def _knots(time: np.ndarray, values: np.ndarray, closer: float) -> np.ndarray:
    """Knots close enough for the frequency up to which the motion is resolved, and closer by a factor."""
    step = time[1] - time[0]
    apart = step * max(1 / (PER_PERIOD * resolved_frequency(values, 1 / step) * step), CLOSEST) / closer
    inner = np.arange(time[0] + apart, time[-1] - max(apart, (DEGREE + 1) * step), apart)
    return np.concatenate([[time[0]] * (DEGREE + 1), inner, [time[-1]] * (DEGREE + 1)])


def _without_noise(values: np.ndarray) -> np.ndarray:
    """A motion (n,) without the frequencies at which it is not resolved from its noise."""
    n = len(values)
    line = np.interp(np.arange(n), [0, n - 1], values[[0, -1]])
    _, power = _smooth_spectrum(values, 1.0)
    return line + np.fft.irfft(np.where(power > ABOVE_NOISE * _floor(power), np.fft.rfft(values - line), 0.0), n)


def resolved_frequency(values: np.ndarray, rate: float, ratio: float = ABOVE_NOISE) -> float:
    """The frequency [Hz] up to which the power of a motion (n,) exceeds that of its noise by a ratio.

        f = argmax over f of the sum up to f of (P / N - ratio)

    P is the smoothed power and N its floor. The cumulative sum is that of a change of the mean, so that an isolated
    line far beyond the motion, such as mains interference, does not count. Half the sampling rate where no floor is
    below the motion.

    Source: Page, Biometrika 41 (1954) 100-115.
    """
    frequency, power = _smooth_spectrum(values, rate)
    excess = np.cumsum(power / _floor(power) - ratio)
    return float(frequency[np.argmax(excess) if excess.max() > 0 else -1])


def _floor(power: np.ndarray) -> float:
    """The level at which a smoothed spectrum (m,) is flat: the half-sample mode of its logarithm.

    It is the level of white noise, and that of noise that is flat up to the cut-off of a low-pass filter.

    Source: Bickel, Fruehwirth, Computational Statistics and Data Analysis 50 (2006) 3500-3530.
    """
    logs = np.sort(np.log(np.maximum(power, TINY)))
    while len(logs) > 2:
        half = (len(logs) + 1) // 2
        first = int(np.argmin(logs[half - 1 :] - logs[: len(logs) - half + 1]))
        logs = logs[first : first + half]
    return float(np.exp(logs.mean()))


def highest_frequency(values: np.ndarray, rate: float, share: float = 4.0) -> float:
    """The highest frequency [Hz] at which a signal (n,) exceeds its level at the highest frequencies.

    At most LEAST_POWER of the power lies above it.
    """
    frequency, power = _smooth_spectrum(values, rate)
    floor = float(np.median(power[int(0.7 * len(power)) :]))
    beyond = np.cumsum(power[::-1])[::-1] / power.sum()
    above = np.flatnonzero((power > share * floor) & (beyond > LEAST_POWER))
    return float(frequency[above[-1]]) if len(above) else float(frequency[-1] / 2)


def _smooth_spectrum(values: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (m,) and the smoothed power of a signal (n,) there."""
    n = len(values)
    line = np.interp(np.arange(n), [0, n - 1], values[[0, -1]])
    frequency, power = periodogram((values - line) * np.hanning(n), rate)
    width = max(n // 400, 5)
    return frequency, np.convolve(power, np.ones(width) / width, "same")
