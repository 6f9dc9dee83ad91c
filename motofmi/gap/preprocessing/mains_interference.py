"""Mains and machines in a sensor's wire: lines that stand still all through a run, whatever moves.

    y(t) - a cos(2 pi f t) - b sin(2 pi f t)

Where the excitation is swept, what it causes lies on its harmonics, which sweep too. In a component's run a body more on a spring that
nothing damps would be named. What answers to a periodic input has lines of its own there, so that they are looked for only where
no input has any; a mode that is driven at random changes its amplitude.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from identification.gap.data.reduction import Reduction
from identification.recordings import Recording

AROUND = 2.0  # Hz beside a line, with whose median it is compared
OUTSIDE = 60.0  # times that median: outside of harmonics there is little else
LINE = 200.0  # the same of all that a component does
FAINT = 1e-10  # of the strongest line: rounding, and what leaks
BESIDE = 30.0  # times the power four to eight lines beside it, where Hann's window shows nothing of a line
SLOWEST = 5.0  # Hz
MOSTLY = 0.6  # share of the windows in which it stands out
PARTS, STEADY = 6, 0.3  # of the run, in which its amplitude is that of the whole, but for such a share
MOST = 5  # lines
FEWEST = 1000  # samples


def hum_of(reduction: Reduction, y: np.ndarray) -> list[float]:
    """Frequencies [Hz] at which y (n,) hums outside of the harmonics of a swept run."""
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
        if apart and np.mean([_stands_out(part, f[i] / reduction.rate) for part in parts]) > MOSTLY:
            found.append(float(f[i]))
    return sorted(found)


def _stands_out(part: np.ndarray, cycles: float) -> bool:
    """Whether a window's part (n,) is louder at so many cycles per sample than beside it: of noise one in 16 is."""
    n = len(part)
    beside = cycles + np.array([0.0, -10, -8, -6, -4, 4, 6, 8, 10]) / n  # Hann's lobe is four lines wide
    power = np.abs(np.exp(-2j * np.pi * np.outer(beside, np.arange(n))) @ part) ** 2
    return bool(power[0] > 4 * np.median(power[1:]))


def _around(power: np.ndarray, n: int, rate: float) -> np.ndarray:
    """The median power around each line of the spectrum of n samples."""
    return np.maximum(median_filter(power, 2 * int(AROUND * n / rate) + 1), FAINT * power.max() + 1e-300)


def without_hum(recording: Recording, inputs: Sequence[str], outputs: Sequence[str]) -> tuple[Recording, tuple[str, ...]]:
    """A component's recording on a regular grid without what hums in its outputs, and what was taken out."""
    if len(recording.time) < FEWEST or any(_lines(recording[n], recording.rate).any() for n in inputs if np.ptp(recording[n]) > 0):
        return recording, ()
    columns, notes = dict(recording.columns), []
    for name in outputs:
        found: list[str] = []
        while len(found) < MOST and (line := _hum(columns[name], recording)):
            frequency, wave = line
            columns[name] = columns[name] - wave
            found.append(f"{frequency:.4g} Hz ({np.sqrt(2) * np.std(wave):.2g} {recording.units[name]})")
        if found:
            notes.append(f"{recording.name}: {name} hums at {', '.join(found)}, which is taken out")
    return replace(recording, columns=columns), tuple(notes)


def _lines(y: np.ndarray, rate: float) -> np.ndarray:
    """Which lines of the spectrum of y (n,) stand alone."""
    power = np.abs(np.fft.rfft((y - y.mean()) * np.hanning(len(y)))) ** 2
    beside = np.max([np.roll(power, k) for k in (*range(-8, -3), *range(4, 9))], axis=0)
    lines = power > np.maximum(LINE * _around(power, len(y), rate), BESIDE * beside)
    return lines & (power >= np.maximum(np.roll(power, 1), np.roll(power, -1)))


def _hum(y: np.ndarray, recording: Recording) -> tuple[float, np.ndarray] | None:
    """The first line of y (n,) that is steady: its frequency [Hz], and the wave (n,) itself."""
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
    """Of y (n,) at a line: a - i b by least squares under Hann's window, to which the motion elsewhere is nothing."""
    window = np.hanning(len(y))
    columns = window[:, None] * np.column_stack([turn.real, -turn.imag, np.ones(len(y))])
    a, b = np.linalg.lstsq(columns, window * y, rcond=None)[0][:2]
    return complex(a, b)
