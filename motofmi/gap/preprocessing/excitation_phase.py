"""The phase of a swept or stepped excitation, and the intervals of a run in which it changes slowly.

    c(t) = a(t) cos(phi(t)),   phi from the analytic signal,   f = phi' / 2 pi
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_lsq_spline
from scipy.ndimage import uniform_filter1d

from motofmi.recordings.spectra import analytic_signal

SETTLING_TIME = 3.5  # s after a step of frequency or amplitude, in which the transients of a rider decay
FREQUENCY_STEP = 0.1  # Hz within a second: a faster change of the frequency is a step
END_TIME = 1.0  # s left out at the end of a recording, where the analytic signal is not accurate
WINDOW_CYCLES = 4.0  # least number of cycles in a window
WINDOW_TIME = 2.5  # s, least length of a window
COMMAND_KNOT_FACTOR = 2.0  # ratio of knot distances of a measured phase to those of a command's phase, without noise
LOWEST_FREQUENCY = 0.1  # Hz, limit of the length of windows
LEAST_AMPLITUDE = 0.2  # over the usual amplitude: below it the excitation has not started or has ended


@dataclass(frozen=True)
class Phase:
    """The phase angle (n,) [rad] and the frequency (n,) [Hz] of a run.

    intervals [first, last) are the samples between steps of the excitation, without transients; windows [first, last)
    divide them.
    """

    angle: np.ndarray
    frequency: np.ndarray
    intervals: tuple[tuple[int, int], ...]
    windows: tuple[tuple[int, int], ...]


def phase_of(command: np.ndarray, rate: float, noisy: bool = False, broken: np.ndarray | bool = False) -> Phase | None:
    """The phase of a command (n,) sampled at `rate` [Hz]; None where it has no single, slowly changing frequency.

    Intervals end at the samples where `broken` (n,) is true. `noisy` says that the command is a measured motion. The
    knots of its phase are then no closer than those of the motion that is reconstructed with it; otherwise noise of the
    phase would become part of that motion.
    """
    centred = command - np.median(command)
    signal = analytic_signal(centred)
    angle, size = np.unwrap(np.angle(signal)), np.abs(signal)
    width = max(int(0.6 * rate), 3)
    frequency = uniform_filter1d(np.gradient(angle) * rate / (2 * np.pi), width, mode="nearest")
    size = uniform_filter1d(size, width, mode="nearest")
    usual = np.quantile(size, 0.9)
    lag = max(int(rate), 2)  # one second: the analytic signal smooths a step
    change = np.zeros(len(command))
    change[:-lag] = np.abs(frequency[lag:] - frequency[:-lag])
    growth = np.zeros(len(command))
    growth[:-lag] = np.abs(size[lag:] - size[:-lag]) / usual
    steps = (
        broken
        | (change > 5 * np.median(change) + FREQUENCY_STEP)
        | (growth > 0.15 + 5 * np.median(growth))
        | (size < LEAST_AMPLITUDE * usual)
    )
    steps[-int(END_TIME * rate) :] = True
    intervals = _settled(~steps, int(SETTLING_TIME * rate))
    inside = _inside(intervals)
    if len(inside) < 0.3 * len(command) or np.any(frequency[inside] <= 0):
        return None
    index, apart = np.arange(len(command)) / rate, window_length(frequency) / (1.0 if noisy else COMMAND_KNOT_FACTOR)
    for first, last in intervals:
        here = slice(max(first - int(SETTLING_TIME * rate / 2), 0), min(last + int(END_TIME * rate), len(command)))
        # A spline, since the ends of a recording add an error at twice the frequency to the analytic signal.
        angle[here] = make_lsq_spline(index[here], angle[here], knots_of(index[here], apart[here]), 3)(index[here])
    return Phase(angle, frequency, tuple(intervals), tuple(_windows(intervals, frequency, rate)))


def window_length(frequency: np.ndarray) -> np.ndarray:
    """The length of windows, and the distance of spline knots [s], at frequencies (n,) [Hz]."""
    return np.maximum(WINDOW_TIME, WINDOW_CYCLES / np.maximum(frequency, LOWEST_FREQUENCY))


def knots_of(time: np.ndarray, apart: np.ndarray, borders: np.ndarray | None = None) -> np.ndarray:
    """The knots [s] of a cubic spline over times (n,) [s], at distances (n,) [s] and at the borders (k,) [s].

    The first and the last knot are fourfold.
    """
    inner: list[float] = []
    at, borders = time[0], np.zeros(0) if borders is None else borders
    while True:
        step = apart[min(np.searchsorted(time, at), len(time) - 1)]
        ahead = borders[(borders > at) & (borders < at + step)]
        at = ahead[0] if len(ahead) else at + step
        if at > time[-1] - step:
            return np.concatenate([[time[0]] * 4, inner, [time[-1]] * 4])
        inner.append(at)


def _settled(good: np.ndarray, settle: int) -> list[tuple[int, int]]:
    """The intervals [first, last) of good samples (n,) without the first `settle` samples of each."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))
    runs = zip(edges[::2], edges[1::2], strict=True)
    return [(int(first) + settle, int(last)) for first, last in runs if last - first - settle > settle / 2]


def _inside(intervals: list[tuple[int, int]]) -> np.ndarray:
    """The indices of all samples in the intervals."""
    return np.concatenate([np.arange(*s) for s in intervals]) if intervals else np.zeros(0, int)


def _windows(intervals: list[tuple[int, int]], frequency: np.ndarray, rate: float) -> list[tuple[int, int]]:
    """The intervals in windows of at least `WINDOW_TIME` and `WINDOW_CYCLES`; the last window includes the rest."""
    windows = []
    for first, last in intervals:
        spread = np.ptp(frequency[first:last])
        start = first
        while start < last:
            length = int(window_length(frequency[start]) * rate)
            end = start + length
            if spread < FREQUENCY_STEP or last - end < length:
                end = last
            windows.append((start, end))
            start = end
    return windows
