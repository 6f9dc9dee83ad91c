"""Recorded inputs as functions of time, and an imposed motion with its rate and acceleration.

Between its samples an input is held, linear or smooth. For inputs with much power near half the sampling rate these
interpolations differ by a delay of up to half a sample, which a fit would attribute to the component. Up to half the
sampling rate, a held input equals the linear interpolation of sharpened samples, half a sample later.

An imposed motion is a spline. Its knots are as far apart as the highest frequency allows at which the motion exceeds
its noise; with closer knots the acceleration would contain differentiated noise. Where the noise of the measured force
is estimated, a motion without its own noise is used, since that noise must not explain the noise of the force. The
difference between two splines shows how accurately an input is known between its samples.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from scipy.interpolate import CubicSpline, LSQUnivariateSpline, make_interp_spline

from motofmi.recordings.resampling import quantisation_step
from motofmi.recordings.spectra import periodogram

CACHED = 32  # sets of times whose values are cached
HELD = "held"
INTERPOLATIONS = ("smooth", "lines", HELD)
SMOOTHER = "smoother"
NOISELESS = "noiseless"
ABOVE_NOISE = 10.0  # ratio of power to noise power above which a motion is resolved
TINY = 1e-300  # added where the logarithm of a power is taken
ROUGH_SHARE = 0.02  # share of an input's power in the upper half of its spectrum above which the interpolations differ
DEGREE = 5  # degree of splines: the acceleration is then smooth
AREA_FACTOR = float(np.sqrt(9 / 5 / 12))  # see `unresolved_input`
LEAST_POWER = 1e-6  # share of a signal's power that may lie above the highest frequency
KNOTS_PER_PERIOD = 6.0  # knots per period of the highest frequency: a spline's acceleration is accurate within 0.2 %
LEAST_KNOTS_PER_PERIOD = 3.0  # knots per period with which a spline's acceleration is accurate within 7 %
LEAST_KNOT_DISTANCE = 2.0  # samples between the knots of an imposed motion
# Ratio of an imposed motion's power to its noise down to which the run is compared: there 1 % of the acceleration's
# power is noise.
RESOLVED_RATIO = 100.0


@dataclass
class InterpolatedInputs:
    """Functions of time [s] by name; a call with times (n,) gives their values (n,) by name and caches them.

    ends are the first and the last time [s]; beyond them inputs keep their last value.
    """

    functions: Mapping[str, Callable[[np.ndarray], np.ndarray]]
    ends: tuple[float, float]
    cache: dict = field(default_factory=dict)

    def scaled(self, factor: float) -> "InterpolatedInputs":
        """All inputs times a factor."""
        return InterpolatedInputs(
            {name: _times(factor, function) for name, function in self.functions.items()}, self.ends
        )

    def __call__(self, time: np.ndarray) -> dict[str, np.ndarray]:
        key = hash(time.tobytes())
        if key not in self.cache:
            if len(self.cache) > CACHED:
                self.cache.clear()
            inside = np.clip(time, *self.ends)
            self.cache[key] = {name: function(inside) for name, function in self.functions.items()}
        return self.cache[key]


def _times(factor: float, function: Callable[[np.ndarray], np.ndarray]) -> Callable[[np.ndarray], np.ndarray]:
    return lambda time: factor * function(time)


def input_function(time: np.ndarray, values: np.ndarray, kind: str) -> Callable[[np.ndarray], np.ndarray]:
    """An input as a function of time [s], from its samples (n,) at times (n,); kind is one of `INTERPOLATIONS`.

    `SMOOTHER` gives a second spline, which differs by what the samples do not resolve (see `unresolved_input`).
    """
    if kind in ("smooth", NOISELESS):
        return CubicSpline(time, values)
    if kind == SMOOTHER:
        return make_interp_spline(time, values + unresolved_input(values), DEGREE)
    if kind == "lines":
        return lambda t: np.interp(t, time, values)
    late, sharp = (time[1] - time[0]) / 2, _sharpened(values)
    return lambda t: np.interp(t - late, time, sharp)


def _sharpened(values: np.ndarray) -> np.ndarray:
    """Samples (n,) whose linear interpolation has the spectrum of the held ones.

    Holding multiplies the spectrum by sinc(f T), linear interpolation by its square.
    """
    n = len(values)
    mirrored = np.concatenate([values, values[::-1]])
    return np.fft.irfft(np.fft.rfft(mirrored) / np.sinc(np.fft.rfftfreq(2 * n)), 2 * n)[:n]


def unresolved_input(values: np.ndarray) -> np.ndarray:
    """The part (n,) of an input's time integral that its samples (n,) do not resolve, in the input's unit.

    It is per sample, with random sign:

        e4_k = d^4 u_k / 6,  e6_k = d^6 u_k / 20      error of predicting u_k from its 4, or 6, neighbours
        deviation = AREA_FACTOR |e4_k| min(1, sum e6^2 / sum e4^2)

    The time of a jump J within a sample interval h is unknown: the time integral has the standard deviation J h /
    sqrt(12), and sum e4^2 is 5 J^2 / 9. For a smooth input the prediction error is smaller with more neighbours.
    """
    middle = slice(3, -3)
    by_four, by_six = np.zeros(len(values)), np.diff(values, 6) / 20
    by_four[2:-2] = np.diff(values, 4) / 6
    power = float(np.sum(by_four[middle] ** 2))
    alike = min(1.0, float(np.sum(by_six**2)) / power) if power > 0 else 0.0
    return AREA_FACTOR * alike * by_four * np.random.default_rng(0).choice([-1.0, 1.0], len(values))


def is_rough(values: np.ndarray) -> bool:
    """Whether an input (n,) has so much power near half the sampling rate that its interpolations differ."""
    _, power = periodogram(values - values.mean())
    return float(power[len(power) // 2 :].sum()) > ROUGH_SHARE * float(power.sum())


def is_held(values: np.ndarray) -> bool:
    """Whether an input (n,) changes in fewer than half of its sampling intervals, as a command in steps."""
    return bool(0 < np.count_nonzero(np.diff(values)) < (len(values) - 1) / 2)


def motion_functions(
    time: np.ndarray, values: np.ndarray, rate: str, kind: str = INTERPOLATIONS[0]
) -> dict[str, Callable]:
    """Functions of time for an imposed motion, its rate and its acceleration, named "", rate and der(rate).

    values (n,) are its samples at times (n,) [s], rate is the name of the rate.
    """
    values = _without_noise(values) if kind == NOISELESS else values
    knots = _inner_knots(time, values, 1.5 if kind == SMOOTHER else 1.0)
    # Its time is proportional to the samples; that of make_lsq_spline to samples times knots, thus to their square.
    spline = LSQUnivariateSpline(time, values, knots, k=DEGREE)
    return {"": spline, rate: spline.derivative(1), f"der({rate})": spline.derivative(2)}


def _inner_knots(time: np.ndarray, values: np.ndarray, closer: float) -> np.ndarray:
    """Knots [s] for the frequency up to which the motion is resolved, at distances divided by the factor `closer`."""
    step = time[1] - time[0]
    samples = max(1 / (KNOTS_PER_PERIOD * resolved_frequency(values, 1 / step) * step), LEAST_KNOT_DISTANCE)
    distance = step * samples / closer
    return np.arange(time[0] + distance, time[-1] - max(distance, (DEGREE + 1) * step), distance)


def _without_noise(values: np.ndarray) -> np.ndarray:
    """A motion (n,) without the frequencies at which it is not resolved from its noise."""
    n = len(values)
    line = np.interp(np.arange(n), [0, n - 1], values[[0, -1]])
    _, power = _smooth_spectrum(values, 1.0)
    resolved = power > ABOVE_NOISE * _noise_level(power)
    return line + np.fft.irfft(np.where(resolved, np.fft.rfft(values - line), 0.0), n)


def resolved_frequency(values: np.ndarray, rate: float, ratio: float = ABOVE_NOISE) -> float:
    """The frequency [Hz] up to which the power of a motion (n,) exceeds that of its noise by a ratio.

        f = argmax over f of the sum up to f of (P / N - ratio)

    P is the smoothed power and N its floor. The cumulative sum is that of a change of the mean, so that an isolated
    line far beyond the motion, such as mains interference, does not count. Half the sampling rate where no floor is
    below the motion.

    Source: Page, Biometrika 41 (1954) 100-115.
    """
    frequency, power = _smooth_spectrum(values, rate)
    excess = np.cumsum(power / _noise_level(power) - ratio)
    return float(frequency[np.argmax(excess) if excess.max() > 0 else -1])


def compared_motion(values: np.ndarray, rate: float) -> float:
    """The frequency [Hz] up to which the acceleration of an imposed motion (n,) is resolved from its noise and by its
    samples."""
    by_samples = rate / (LEAST_KNOTS_PER_PERIOD * LEAST_KNOT_DISTANCE)
    return min(resolved_frequency(values, rate, RESOLVED_RATIO), by_samples)


def _noise_level(power: np.ndarray) -> float:
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
    """The highest frequency [Hz] at which a signal (n,) exceeds its level near half the sampling rate by a factor.

    A share of `LEAST_POWER` of its power or less lies above it. The level is at least that of white noise with the
    variance of the quantisation: that of a slow quantised signal falls towards half the sampling rate.
    """
    frequency, power = _smooth_spectrum(values, rate)
    quantised = 2 / rate * quantisation_step(values) ** 2 / 12 * float(np.mean(np.hanning(len(values)) ** 2))
    floor = max(float(np.median(power[int(0.7 * len(power)) :])), quantised)
    beyond = np.cumsum(power[::-1])[::-1] / power.sum()
    above = np.flatnonzero((power > share * floor) & (beyond > LEAST_POWER))
    return float(frequency[above[-1]]) if len(above) else float(frequency[-1] / 2)


def _smooth_spectrum(values: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (m,), in the unit of the sampling rate, and the smoothed power (m,) of a signal (n,)."""
    n = len(values)
    line = np.interp(np.arange(n), [0, n - 1], values[[0, -1]])
    frequency, power = periodogram((values - line) * np.hanning(n), rate)
    width = max(n // 400, 5)
    return frequency, np.convolve(power, np.ones(width) / width, "same")
