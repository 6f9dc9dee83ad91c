"""Recordings without an input, such as free decays: the highest frequency of their motion, and its equilibrium.

A free motion consists of its modes and their harmonics. Beyond these its spectrum is that of the sensor, which may
exceed its level near half the sampling rate, as where a low-pass filter of the sensor cuts its noise off.

A deflection that oscillates without an input does so about its equilibrium, where a spring has no force. One that never
passes zero has an offset, such as the angle of a hanging pendulum that is counted from the top.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from fmus.declaration.elements import Element
from motofmi.gap.preprocessing.input_interpolation import ABOVE_NOISE, highest_frequency
from motofmi.gap.preprocessing.one_way import oscillates
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import sensor_noise, varies

HARMONICS = 10  # highest frequency of a free motion over its mean frequency, unless modes with more power lie beyond
FURTHER_MODES = 1e-3  # share of the power that may lie beyond the highest frequency
EQUILIBRIUM = (
    "{}: {} oscillates about {:.4g} {} without an input: it is counted from there, since the offset of its sensor is "
    "not known"
)


def is_free(recording: Recording, inputs: Iterable[str]) -> bool:
    """Whether none of these inputs varies in a recording."""
    return not any(varies(recording[name]) for name in inputs if name in recording.columns)


def about_equilibrium(
    recording: Recording, inputs: Iterable[str], elements: Iterable[Element]
) -> tuple[Recording, tuple[str, ...]]:
    """The recording with the deflections of elements counted from their means where they oscillate on one side of zero
    without an input, and notes on these."""
    deflections = sorted({e.deflection for e in elements if e.deflection in recording.columns})
    found = [n for n in deflections if abs(np.sign(recording[n]).sum()) == len(recording[n]) and oscillates(recording[n])]
    if not found or not is_free(recording, inputs):
        return recording, ()
    means = {n: float(recording[n].mean()) for n in found}
    notes = tuple(EQUILIBRIUM.format(recording.name, n, mean, recording.units[n]) for n, mean in means.items())
    columns = {n: y - means.get(n, 0.0) for n, y in recording.columns.items()}
    return replace(recording, columns=columns), notes


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
