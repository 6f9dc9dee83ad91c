"""The phase of a swept or stepped excitation, and the stretches of a run in which it changes slowly.

    c(t) = a(t) cos(phi(t)),   phi from the analytic signal,   f = phi' / 2 pi
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_lsq_spline
from scipy.ndimage import uniform_filter1d
from scipy.signal import hilbert

SETTLE = 3.5  # s after a step of frequency or amplitude, until transients have died
JUMP = 0.1  # Hz within a second: what is no sweep
END = 1.0  # s at the end of a record
CYCLES = 4.0  # that a window holds at least
WINDOW = 2.5  # s that a window lasts at least
FINER = 2.0  # times: the knots of the phase of a command, which has no noise
SLOWEST = 0.1  # Hz
LOWEST = 0.2  # of the usual amplitude: below it the excitation has not begun or has ended


@dataclass(frozen=True)
class Phase:
    """phi (n,) [rad] and frequency (n,) [Hz] of a run, and its stretches [first, last) of slow change."""

    angle: np.ndarray
    frequency: np.ndarray
    stretches: tuple[tuple[int, int], ...]
    windows: tuple[tuple[int, int], ...]


def phase_of(command: np.ndarray, rate: float, noisy: bool = False, broken: np.ndarray | bool = False) -> Phase | None:
    """The phase of a command (n,) sampled at `rate` [Hz]; None where it has not one slowly changing frequency.

    Where the record is broken (n,), no stretch goes on. The phase of a noisy motion is no finer than what is rebuilt with it: else its
    noise would be in the motion, where nothing tells it.
    """
    centred = command - np.median(command)
    signal = hilbert(centred)
    angle, size = np.unwrap(np.angle(signal)), np.abs(signal)
    width = max(int(0.6 * rate), 3)
    frequency = uniform_filter1d(np.gradient(angle) * rate / (2 * np.pi), width, mode="nearest")
    size = uniform_filter1d(size, width, mode="nearest")
    usual = np.quantile(size, 0.9)
    lag = max(int(rate), 2)  # both look a second ahead, which keeps what the analytic signal smears out as well
    change = np.zeros(len(command))
    change[:-lag] = np.abs(frequency[lag:] - frequency[:-lag])
    growth = np.zeros(len(command))
    growth[:-lag] = np.abs(size[lag:] - size[:-lag]) / usual
    jumps = broken | (change > 5 * np.median(change) + JUMP) | (growth > 0.15 + 5 * np.median(growth)) | (size < LOWEST * usual)
    jumps[-int(END * rate) :] = True
    stretches = _runs(~jumps, int(SETTLE * rate))
    if sum(last - first for first, last in stretches) < 0.3 * len(command) or np.any(frequency[_inside(stretches)] <= 0):
        return None
    index, apart = np.arange(len(command)) / rate, lasting(frequency) / (1.0 if noisy else FINER)
    for first, last in stretches:
        here = slice(max(first - int(SETTLE * rate / 2), 0), min(last + int(END * rate), len(command)))
        # A spline, since the ends of a record make the analytic signal swing twice a cycle.
        angle[here] = make_lsq_spline(index[here], angle[here], knots_of(index[here], apart[here]), 3)(index[here])
    return Phase(angle, frequency, tuple(stretches), tuple(_windows(stretches, frequency, rate)))


def lasting(frequency: np.ndarray) -> np.ndarray:
    """How long windows last, and splines take from knot to knot [s], at frequencies (n,) [Hz]."""
    return np.maximum(WINDOW, CYCLES / np.maximum(frequency, SLOWEST))


def knots_of(time: np.ndarray, apart: np.ndarray, borders: np.ndarray | None = None) -> np.ndarray:
    """Knots of a cubic spline over times (n,) [s], so far apart (n,) [s] at each, one at each border (k,) [s], the ends fourfold."""
    inner: list[float] = []
    at, borders = time[0], np.zeros(0) if borders is None else borders
    while True:
        step = apart[min(np.searchsorted(time, at), len(time) - 1)]
        ahead = borders[(borders > at) & (borders < at + step)]
        at = ahead[0] if len(ahead) else at + step
        if at > time[-1] - step:
            return np.concatenate([[time[0]] * 4, inner, [time[-1]] * 4])
        inner.append(at)


def _runs(good: np.ndarray, settle: int) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))
    runs = zip(edges[::2], edges[1::2], strict=True)
    return [(int(first) + settle, int(last)) for first, last in runs if last - first - settle > settle / 2]


def _inside(stretches: list[tuple[int, int]]) -> np.ndarray:
    return np.concatenate([np.arange(*s) for s in stretches]) if stretches else np.zeros(0, int)


def _windows(stretches: list[tuple[int, int]], frequency: np.ndarray, rate: float) -> list[tuple[int, int]]:
    """Each stretch in windows of at least WINDOW seconds and CYCLES cycles; the last one takes the rest."""
    windows = []
    for first, last in stretches:
        spread = np.ptp(frequency[first:last])
        start = first
        while start < last:
            length = int(lasting(frequency[start]) * rate)
            end = start + length
            if spread < JUMP or last - end < length:
                end = last
            windows.append((start, end))
            start = end
    return windows
