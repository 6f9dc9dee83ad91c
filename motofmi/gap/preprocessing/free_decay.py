"""Recordings without an input, such as free decays, and the highest frequency of their motion.

A free motion consists of its modes and their harmonics. Beyond these its spectrum is that of the sensor, which may
exceed its level near half the sampling rate, as where a low-pass filter of the sensor cuts its noise off.
"""

from collections.abc import Iterable

import numpy as np

from motofmi.gap.preprocessing.input_interpolation import ABOVE_NOISE, highest_frequency
from motofmi.gap.preprocessing.one_way import oscillates
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import sensor_noise, varies

HARMONICS = 10  # highest frequency of a free motion over its mean frequency, unless modes with more power lie beyond
FURTHER_MODES = 1e-3  # share of the power that may lie beyond the highest frequency


def is_free(recording: Recording, inputs: Iterable[str]) -> bool:
    """Whether none of these inputs varies in a recording."""
    return not any(varies(recording[name]) for name in inputs if name in recording.columns)


def highest_of_motion(values: np.ndarray, rate: float, free: bool) -> float:
    """The highest frequency [Hz] of a motion (n,) with a sampling rate [Hz]; free where no input varies.

    A motion that does not oscillate, as of a pendulum that goes round, is limited by its noise alone: its mean
    frequency is not that of its modes.
    """
    highest = highest_frequency(values, rate)
    if not (free and oscillates(values)):
        return highest
    return min(highest, max(HARMONICS * mean_frequency(values, rate), nearly_highest(values, rate)))


def nearly_highest(values: np.ndarray, rate: float) -> float:
    """The frequency [Hz] beyond which a signal (n,) has a share of `FURTHER_MODES` of its power; 0 for a constant."""
    frequency, power = _windowed_power(values, rate)
    beyond = np.cumsum(power[::-1])[::-1] / max(power.sum(), 1e-300)
    return float(frequency[np.flatnonzero(beyond > FURTHER_MODES)[-1]]) if power.sum() else 0.0


def mean_frequency(values: np.ndarray, rate: float) -> float:
    """The power-weighted mean frequency [Hz] of a signal (n,) about its mean, where it exceeds its noise.

    The mean is that of the motion itself. The mean frequency of its differences would depend on the sampling rate and
    on the noise, since the power of differences grows with the frequency.
    """
    frequency, power = _windowed_power(values, rate)
    clear = power > ABOVE_NOISE * sensor_noise(values - values.mean()) ** 2 * np.sum(np.hanning(len(values)) ** 2)
    return float(np.sum(power[clear] * frequency[clear]) / max(np.sum(power[clear]), 1e-300))


def _windowed_power(values: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and power (m,) of a signal (n,) about its mean, in a Hann window."""
    power = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values)))) ** 2
    return np.fft.rfftfreq(len(values), 1 / rate), power
