"""Mains interference: spectral lines of constant frequency and amplitude in a sensor, independent of the motion.

    y(t) - a cos(2 pi f t) - b sin(2 pi f t)

In a swept run the response lies on harmonics of the excitation, which are swept too. In a component's run such a line
would be fitted by an undamped additional body. The response to a periodic input has lines as well, so lines are removed
only where no input has any; a randomly excited mode changes its amplitude during the run and is not removed.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from motofmi.gap.preprocessing.harmonics import Reduction
from motofmi.recordings.recording import Recording

AROUND = 2.0  # Hz around a line, over which its power is compared with the median
OUTSIDE = 60.0  # ratio to that median outside harmonics: of noise one line in 10^18
LINE = 200.0  # the same ratio in a component's output, where the response is in the spectrum too
FAINT = 1e-10  # of the strongest line: rounding and leakage
BESIDE = 30.0  # ratio to the power four to eight lines beside it, outside the main lobe of Hann's window
SLOWEST = 5.0  # Hz
MOSTLY = 0.6  # share of the windows in which it exceeds its surroundings
PARTS, STEADY = 6, 0.3  # parts of the run, and the relative difference of a part's amplitude from that of the whole
MOST = 5  # lines
FEWEST = 1000  # samples


def interference_lines(reduction: Reduction, y: np.ndarray) -> list[float]:
    """Frequencies [Hz] of mains interference in y (n,) outside the harmonics of a swept run."""
    parts = [part * np.hanning(len(part)) for part in reduction.residuals(y)]
    left = np.zeros(len(y))
    for (first, last, _), part in zip(reduction.outside, parts, strict=True):
        left[first:last] = part
    f, power = np.fft.rfftfreq(len(y), 1 / reduction.rate), np.abs(np.fft.rfft(left)) ** 2
    above = power / _around(power, len(y), reduction.rate)
    found: list[float] = []
    for i in np.argsort(-above):
        if above[i] < OUTSIDE or len(found) == MOST:
            break
        apart = f[i] > SLOWEST and all(abs(f[i] - other) > AROUND for other in found)
        if apart and np.mean([_exceeds_adjacent(part, f[i] / reduction.rate) for part in parts]) > MOSTLY:
            found.append(float(f[i]))
    return sorted(found)


def _exceeds_adjacent(part: np.ndarray, cycles: float) -> bool:
    """Whether the power of a window's part (n,) at a frequency [cycles per sample] exceeds that beside it: of
    noise one in 16 does."""
    n = len(part)
    beside = cycles + np.array([0.0, -10, -8, -6, -4, 4, 6, 8, 10]) / n  # Hann's lobe is four lines wide
    power = np.abs(np.exp(-2j * np.pi * np.outer(beside, np.arange(n))) @ part) ** 2
    return bool(power[0] > 4 * np.median(power[1:]))


def _around(power: np.ndarray, n: int, rate: float) -> np.ndarray:
    """The median power around each line of the spectrum of n samples."""
    return np.maximum(median_filter(power, 2 * int(AROUND * n / rate) + 1), FAINT * power.max() + 1e-300)


def without_mains_interference(
    recording: Recording, inputs: Sequence[str], outputs: Sequence[str]
) -> tuple[Recording, tuple[str, ...]]:
    """A component's recording on a regular grid without mains interference in its outputs, and notes
    on what was removed."""
    if len(recording.time) < FEWEST or any(
        _lines(recording[n], recording.rate).any() for n in inputs if np.ptp(recording[n]) > 0
    ):
        return recording, ()
    columns, notes = dict(recording.columns), []
    for name in outputs:
        found: list[str] = []
        while len(found) < MOST and (line := _steady_line(columns[name], recording)):
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
    lines = power > np.maximum(LINE * _around(power, len(y), rate), BESIDE * beside)
    return lines & (power >= np.maximum(np.roll(power, 1), np.roll(power, -1)))


def _steady_line(y: np.ndarray, recording: Recording) -> tuple[float, np.ndarray] | None:
    """The first line of y (n,) with constant amplitude: its frequency [Hz] and its signal (n,)."""
    n = len(y)
    lines = np.flatnonzero(_lines(y, recording.rate))
    for i in lines[lines > SLOWEST * n / recording.rate]:
        near = np.linspace(i - 1, i + 1, 41) / n  # cycles per sample
        seen = np.abs(np.exp(-2j * np.pi * np.outer(near, np.arange(n))) @ ((y - y.mean()) * np.hanning(n)))
        turn = np.exp(2j * np.pi * near[np.argmax(seen)] * np.arange(n))
        amplitude = _amplitude(y, turn)
        parts = [_amplitude(y[k], turn[k]) for k in np.array_split(np.arange(n), PARTS)]
        if all(abs(part - amplitude) < STEADY * abs(amplitude) for part in parts):
            return float(near[np.argmax(seen)] * recording.rate), (amplitude * turn).real
    return None


def _amplitude(y: np.ndarray, turn: np.ndarray) -> complex:
    """The complex amplitude a - i b of y (n,) at a line, by least squares under Hann's window."""
    window = np.hanning(len(y))
    columns = window[:, None] * np.column_stack([turn.real, -turn.imag, np.ones(len(y))])
    a, b = np.linalg.lstsq(columns, window * y, rcond=None)[0][:2]
    return complex(a, b)
