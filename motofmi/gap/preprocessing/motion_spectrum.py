"""The spectrum of a recorded motion: its smoothed power, the level of its noise, and the frequencies it reaches."""

import numpy as np
from scipy.signal import periodogram

from motofmi.recordings.resampling import quantisation_step

ABOVE_NOISE = 10.0  # ratio of power to noise power above which a motion is resolved
ABOVE_FLOOR = 4.0  # ratio of power to the level near half the sampling rate above which a signal has a frequency
LEAST_POWER = 1e-6  # share of a signal's power that may lie above the highest frequency
TINY = 1e-300  # added where the logarithm of a power is taken


def resolved_frequency(values: np.ndarray, rate: float, ratio: float = ABOVE_NOISE) -> float:
    """The frequency [Hz] up to which the power of a motion (n,) exceeds that of its noise by a ratio.

        f = argmax over f of the sum up to f of (P / N - ratio)

    P is the smoothed power and N its floor. The cumulative sum is that of a change of the mean, so that an isolated
    line far beyond the motion, such as mains interference, does not count. Half the sampling rate where no floor is
    below the motion.

    Source: Page, Biometrika 41 (1954) 100-115.
    """
    frequency, power = smooth_spectrum(values, rate)
    excess = np.cumsum(power / noise_level(power) - ratio)
    return float(frequency[np.argmax(excess) if excess.max() > 0 else -1])


def noise_level(power: np.ndarray) -> float:
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


def highest_frequency(values: np.ndarray, rate: float) -> float:
    """The highest frequency [Hz] at which a signal (n,) exceeds its level near half the sampling rate.

    A share of `LEAST_POWER` of its power or less lies above it.
    """
    frequency, power = smooth_spectrum(values, rate)
    beyond = np.cumsum(power[::-1])[::-1] / power.sum()
    above = np.flatnonzero(_exceeds(values, power, rate) & (beyond > LEAST_POWER))
    return float(frequency[above[-1]]) if len(above) else float(frequency[-1] / 2)


def power_shares(values: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (m,) [Hz] and the shares (m,) of a signal's power there, zero where it is at its level near half the
    sampling rate."""
    frequency, power = smooth_spectrum(values, rate)
    above = _exceeds(values, power, rate)
    return frequency, np.where(above | ~above.any(), power, 0.0) / power.sum()


def _exceeds(values: np.ndarray, power: np.ndarray, rate: float) -> np.ndarray:
    """Whether a smoothed power (m,) exceeds the signal's level near half the sampling rate `ABOVE_FLOOR` times.

    The level is at least that of white noise with the variance of the quantisation: that of a slow quantised signal
    falls towards half the sampling rate.
    """
    quantised = 2 / rate * quantisation_step(values) ** 2 / 12 * float(np.mean(np.hanning(len(values)) ** 2))
    return power > ABOVE_FLOOR * max(float(np.median(power[int(0.7 * len(power)) :])), quantised)


def smooth_spectrum(values: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (m,), in the unit of the sampling rate, and the smoothed power (m,) of a signal (n,)."""
    n = len(values)
    line = np.interp(np.arange(n), [0, n - 1], values[[0, -1]])
    frequency, power = periodogram((values - line) * np.hanning(n), rate)
    width = max(n // 400, 5)
    return frequency, np.convolve(power, np.ones(width) / width, "same")
