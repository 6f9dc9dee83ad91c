"""Mains interference: spectral lines of constant frequency and amplitude in a sensor, independent of the motion.

    y(t) - a cos(2 pi f t) - b sin(2 pi f t)

In a swept run the response is at harmonics of the excitation, whose frequency changes. In a run of any component such a
line would be fitted by an undamped additional body. The response to a periodic input has lines as well; therefore lines
are removed only where no input has any. The amplitude of a randomly excited mode changes during the run, so that the
mode is not removed.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from motofmi.gap.preprocessing.harmonics import Reduction
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import varies

MEDIAN_WIDTH = 2.0  # Hz around a line, over which its power is compared with the median
OUTSIDE_RATIO = 60.0  # power over that median outside harmonics: with noise alone, one line in 10^18 exceeds it
OUTPUT_RATIO = 200.0  # the same ratio in a component's output, whose spectrum includes the response
FAINTEST = 1e-10  # power over that of the strongest line below which it is due to rounding and leakage
LOBE_RATIO = 30.0  # power over that four to eight lines beside it, outside the main lobe of Hann's window
LOWEST_FREQUENCY = 5.0  # Hz
WINDOW_SHARE = 0.6  # least share of the windows in which a line exceeds the adjacent ones
PARTS = 6  # parts of the run in which the amplitude of a line is compared
AMPLITUDE_CHANGE = 0.3  # largest relative difference between the amplitude in a part and in the whole run
MOST_LINES = 5  # lines that are removed from one channel
FEWEST_SAMPLES = 1000  # below them no line is removed


def interference_lines(reduction: Reduction, y: np.ndarray) -> list[float]:
    """Frequencies [Hz] of mains interference in y (n,) outside the harmonics of a swept run."""
    parts = [part * np.hanning(len(part)) for part in reduction.residuals(y)]
    left = np.zeros(len(y))
    for (first, last, _), part in zip(reduction.outside, parts, strict=True):
        left[first:last] = part
    f, power = np.fft.rfftfreq(len(y), 1 / reduction.rate), np.abs(np.fft.rfft(left)) ** 2
    above = power / _median_around(power, len(y), reduction.rate)
    found: list[float] = []
    for i in np.argsort(-above):
        if above[i] < OUTSIDE_RATIO or len(found) == MOST_LINES:
            break
        apart = f[i] > LOWEST_FREQUENCY and all(abs(f[i] - other) > MEDIAN_WIDTH for other in found)
        if apart and np.mean([_exceeds_adjacent(part, f[i] / reduction.rate) for part in parts]) > WINDOW_SHARE:
            found.append(float(f[i]))
    return sorted(found)


def _exceeds_adjacent(part: np.ndarray, cycles: float) -> bool:
    """Whether the power of a window (n,) at a frequency [cycles per sample] exceeds that at adjacent frequencies.

    With noise alone this is so in one of 16 windows.
    """
    n = len(part)
    beside = cycles + np.array([0.0, -10, -8, -6, -4, 4, 6, 8, 10]) / n  # Hann's lobe is four lines wide
    power = np.abs(np.exp(-2j * np.pi * np.outer(beside, np.arange(n))) @ part) ** 2
    return bool(power[0] > 4 * np.median(power[1:]))


def _median_around(power: np.ndarray, n: int, rate: float) -> np.ndarray:
    """The median power around each line of the spectrum of n samples at a sampling rate [Hz]."""
    return np.maximum(median_filter(power, 2 * int(MEDIAN_WIDTH * n / rate) + 1), FAINTEST * power.max() + 1e-300)


def without_mains_interference(
    recording: Recording, inputs: Sequence[str], outputs: Sequence[str]
) -> tuple[Recording, tuple[str, ...]]:
    """A uniformly sampled recording without mains interference in its outputs, and notes on the removed lines."""
    excited = (_lines(recording[n], recording.rate).any() for n in inputs if varies(recording[n]))
    if len(recording.time) < FEWEST_SAMPLES or any(excited):
        return recording, ()
    columns, notes = dict(recording.columns), []
    for name in outputs:
        found: list[str] = []
        while len(found) < MOST_LINES and (line := _constant_line(columns[name], recording)):
            frequency, wave = line
            columns[name] = columns[name] - wave
            found.append(f"{frequency:.4g} Hz ({np.sqrt(2) * np.std(wave):.2g} {recording.units[name]})")
        if found:
            notes.append(f"{recording.name}: {name} has mains interference at {', '.join(found)}, which is removed")
    return replace(recording, columns=columns), tuple(notes)


def _lines(y: np.ndarray, rate: float) -> np.ndarray:
    """The isolated lines of the spectrum of y (n,), as a mask."""
    power = np.abs(np.fft.rfft((y - y.mean()) * np.hanning(len(y)))) ** 2
    beside = np.max([np.roll(power, k) for k in (*range(-8, -3), *range(4, 9))], axis=0)
    lines = power > np.maximum(OUTPUT_RATIO * _median_around(power, len(y), rate), LOBE_RATIO * beside)
    return lines & (power >= np.maximum(np.roll(power, 1), np.roll(power, -1)))


def _constant_line(y: np.ndarray, recording: Recording) -> tuple[float, np.ndarray] | None:
    """The first line of y (n,) with constant amplitude: its frequency [Hz] and its signal (n,)."""
    n = len(y)
    lines = np.flatnonzero(_lines(y, recording.rate))
    for i in lines[lines > LOWEST_FREQUENCY * n / recording.rate]:
        near = np.linspace(i - 1, i + 1, 41) / n  # cycles per sample
        seen = np.abs(np.exp(-2j * np.pi * np.outer(near, np.arange(n))) @ ((y - y.mean()) * np.hanning(n)))
        turn = np.exp(2j * np.pi * near[np.argmax(seen)] * np.arange(n))
        amplitude = _amplitude(y, turn)
        parts = [_amplitude(y[k], turn[k]) for k in np.array_split(np.arange(n), PARTS)]
        if all(abs(part - amplitude) < AMPLITUDE_CHANGE * abs(amplitude) for part in parts):
            return float(near[np.argmax(seen)] * recording.rate), (amplitude * turn).real
    return None


def _amplitude(y: np.ndarray, turn: np.ndarray) -> complex:
    """The complex amplitude a - i b of y (n,) at a line, by least squares under Hann's window."""
    window = np.hanning(len(y))
    columns = window[:, None] * np.column_stack([turn.real, -turn.imag, np.ones(len(y))])
    a, b = np.linalg.lstsq(columns, window * y, rcond=None)[0][:2]
    return complex(a, b)
