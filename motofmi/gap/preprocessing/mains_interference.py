"""Mains interference: spectral lines of constant frequency and amplitude in a sensor, independent of the motion.

    y(t) - sum over k of a_k cos(k (2 pi f t + phi(t)) + phi_k)

The phase phi is constant, or drifts with the frequency of the mains.

In a swept run the response is at harmonics of the excitation, whose frequency changes. In a run of any component such a
line would be fitted by an undamped additional body. The response to a periodic input has lines as well, also
at its harmonics; therefore lines are removed only where the lines of every input are negligible. In a closed loop an
input contains the interference of the output. The amplitude of a randomly excited mode changes during the run, so that the mode
is not removed.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import median_filter

from motofmi.gap.preprocessing.harmonics import Reduction
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import varies

MEDIAN_WIDTH = 2.0  # Hz around a line, over which its power is compared with the median
OUTSIDE_RATIO = 60.0  # power over that median outside harmonics: with noise alone, one line in 10^18 exceeds it
OUTPUT_RATIO = 200.0  # the same ratio in a component's output, whose spectrum includes the response
FAINTEST = 1e-10  # power over that of the strongest line below which it is due to rounding and leakage
# Share of an input's power in its lines below which they are no excitation: a mode with a damping ratio of 0.5 % amplifies
# them by 100, to a tenth of the response to the whole input.
NEGLIGIBLE_INPUT = 1e-6
LOBE_RATIO = 30.0  # power over that four to eight lines beside it, outside the main lobe of Hann's window
LOWEST_FREQUENCY = 5.0  # Hz
WINDOW_SHARE = 0.6  # least share of the windows in which a line exceeds the adjacent ones
PARTS = 6  # parts of the run in which the amplitude of a line is compared
AMPLITUDE_CHANGE = 0.3  # largest relative difference between the amplitude in a part and in the whole run
DRIFT_PART = 2.0  # s, of the parts between which the phase of a line may drift: the mains frequency is within 0.05 Hz
MOST_HARMONICS = 5  # of a line, that are removed with it
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
    periodic = (
        _share_of_lines(recording[n], recording.rate) > NEGLIGIBLE_INPUT for n in inputs if varies(recording[n])
    )
    if len(recording.time) < FEWEST_SAMPLES or any(periodic):
        return recording, ()
    columns, notes = dict(recording.columns), []
    for name in outputs:
        found: list[str] = []
        while len(found) < MOST_LINES and (line := _constant_line(columns[name], recording)):
            frequency, turn = line
            wave = (_amplitude(columns[name], turn) * turn).real
            found.append(f"{frequency:.4g} Hz ({np.sqrt(2) * np.std(wave):.2g} {recording.units[name]})")
            highest = min(MOST_HARMONICS, int(recording.rate / 2 / frequency))
            for order in range(1, highest + 1):  # its harmonics drift with it
                columns[name] = columns[name] - (_amplitude(columns[name], turn**order) * turn**order).real
        if found:
            notes.append(f"{recording.name}: {name} has mains interference at {', '.join(found)}, which is removed")
    return replace(recording, columns=columns), tuple(notes)


def _share_of_lines(y: np.ndarray, rate: float) -> float:
    """The share of the power of y (n,) in the isolated lines of its spectrum."""
    power = _windowed_power(y)
    lobes = np.convolve(_lines(y, rate), np.ones(5), "same") > 0  # Hann's lobe is four lines wide
    return float(power[lobes].sum() / power.sum())


def _windowed_power(y: np.ndarray) -> np.ndarray:
    return np.abs(np.fft.rfft((y - y.mean()) * np.hanning(len(y)))) ** 2


def _lines(y: np.ndarray, rate: float) -> np.ndarray:
    """The isolated lines of the spectrum of y (n,), as a mask."""
    power = _windowed_power(y)
    beside = np.max([np.roll(power, k) for k in (*range(-8, -3), *range(4, 9))], axis=0)
    lines = power > np.maximum(OUTPUT_RATIO * _median_around(power, len(y), rate), LOBE_RATIO * beside)
    return lines & (power >= np.maximum(np.roll(power, 1), np.roll(power, -1)))


def _constant_line(y: np.ndarray, recording: Recording) -> tuple[float, np.ndarray] | None:
    """The first line of y (n,) with constant amplitude: its frequency [Hz] and exp(i (2 pi f t + phi)) (n,)."""
    n = len(y)
    lines = np.flatnonzero(_lines(y, recording.rate))
    for i in lines[lines > LOWEST_FREQUENCY * n / recording.rate]:
        near = np.linspace(i - 1, i + 1, 41) / n  # cycles per sample
        seen = np.abs(np.exp(-2j * np.pi * np.outer(near, np.arange(n))) @ ((y - y.mean()) * np.hanning(n)))
        turn = np.exp(2j * np.pi * near[np.argmax(seen)] * np.arange(n))
        for count, drifts in ((PARTS, False), (max(PARTS, int(n / recording.rate / DRIFT_PART)), True)):
            drift = _phase_of_constant(y, turn, count, drifts)
            if drift is not None:
                return float(near[np.argmax(seen)] * recording.rate), turn * np.exp(1j * drift)
    return None


def _phase_of_constant(y: np.ndarray, turn: np.ndarray, count: int, drifts: bool) -> np.ndarray | None:
    """The phase (n,) of a line of y (n,) that has one amplitude in `count` parts; None where it does not.

    turn (n,) is exp(2 pi i f t). Without drift the phase of the parts must be the same, too.
    """
    parts = np.array_split(np.arange(len(y)), count)
    found = np.array([_amplitude(y[k], turn[k]) for k in parts])
    whole = _amplitude(y, turn)
    size = np.mean(np.abs(found)) if drifts else np.abs(whole)
    differences = np.abs(np.abs(found) - size if drifts else found - whole)
    if np.any(differences > AMPLITUDE_CHANGE * size):
        return None
    if not drifts:
        return np.full(len(y), np.angle(whole))
    phase = CubicSpline([k.mean() for k in parts], np.unwrap(np.angle(found)), bc_type="natural")
    return phase(np.arange(len(y)))


def _amplitude(y: np.ndarray, turn: np.ndarray) -> complex:
    """The complex amplitude a - i b of y (n,) at a line, by least squares under Hann's window."""
    window = np.hanning(len(y))
    columns = window[:, None] * np.column_stack([turn.real, -turn.imag, np.ones(len(y))])
    a, b = np.linalg.lstsq(columns, window * y, rcond=None)[0][:2]
    return complex(a, b)
