"""The phase of a swept or stepped excitation, and the intervals of a run in which it changes slowly.

    c(t) = a(t) cos(phi(t)),   phi from the analytic signal,   f = phi' / 2 pi
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_lsq_spline
from scipy.ndimage import uniform_filter1d
from scipy.signal import hilbert

SETTLE = 3.5  # s after a step of frequency or amplitude until transients of a rider have decayed
JUMP = 0.1  # Hz within a second: faster changes of the frequency are steps
END = 1.0  # s left out at the end of a recording
CYCLES = 4.0  # minimum of a window
WINDOW = 2.5  # s, minimum length of a window
FINER = 2.0  # knots of a command's phase, which has no noise, are closer by this factor
SLOWEST = 0.1  # Hz
LOWEST = 0.2  # of the usual amplitude: below it the excitation has not started or has ended


@dataclass(frozen=True)
class Phase:
    """phi (n,) [rad] and frequency (n,) [Hz] of a run, and its intervals [first, last) of slow change."""

    angle: np.ndarray
    frequency: np.ndarray
    stretches: tuple[tuple[int, int], ...]
    windows: tuple[tuple[int, int], ...]


def phase_of(command: np.ndarray, rate: float, noisy: bool = False, broken: np.ndarray | bool = False) -> Phase | None:
    """The phase of a command (n,) sampled at `rate` [Hz]; None where it has no single, slowly changing frequency.

    Intervals end where the recording is broken (n,). The phase of a noisy motion has knots no closer than those of the
    motion that is reconstructed with it, else its noise would become part of that motion.
    """
    centred = command - np.median(command)
    signal = hilbert(centred)
    angle, size = np.unwrap(np.angle(signal)), np.abs(signal)
    width = max(int(0.6 * rate), 3)
    frequency = uniform_filter1d(np.gradient(angle) * rate / (2 * np.pi), width, mode="nearest")
    size = uniform_filter1d(size, width, mode="nearest")
    usual = np.quantile(size, 0.9)
    lag = max(int(rate), 2)  # changes over the next second, since the analytic signal smooths a step
    change = np.zeros(len(command))
    change[:-lag] = np.abs(frequency[lag:] - frequency[:-lag])
    growth = np.zeros(len(command))
    growth[:-lag] = np.abs(size[lag:] - size[:-lag]) / usual
    jumps = (
        broken
        | (change > 5 * np.median(change) + JUMP)
        | (growth > 0.15 + 5 * np.median(growth))
        | (size < LOWEST * usual)
    )
    jumps[-int(END * rate) :] = True
    stretches = _runs(~jumps, int(SETTLE * rate))
    if sum(last - first for first, last in stretches) < 0.3 * len(command) or np.any(
        frequency[_inside(stretches)] <= 0
    ):
        return None
    index, apart = np.arange(len(command)) / rate, lasting(frequency) / (1.0 if noisy else FINER)
    for first, last in stretches:
        here = slice(max(first - int(SETTLE * rate / 2), 0), min(last + int(END * rate), len(command)))
        # A spline, since the ends of a recording add an error at twice the frequency to the analytic signal.
        angle[here] = make_lsq_spline(index[here], angle[here], knots_of(index[here], apart[here]), 3)(index[here])
    return Phase(angle, frequency, tuple(stretches), tuple(_windows(stretches, frequency, rate)))


def lasting(frequency: np.ndarray) -> np.ndarray:
    """The length of windows, and the distance of spline knots [s], at frequencies (n,) [Hz]."""
    return np.maximum(WINDOW, CYCLES / np.maximum(frequency, SLOWEST))


def knots_of(time: np.ndarray, apart: np.ndarray, borders: np.ndarray | None = None) -> np.ndarray:
    """Knots of a cubic spline over times (n,) [s] at distances (n,) [s], one at each border
    (k,) [s], the ends fourfold."""
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
    """Each interval in windows of at least WINDOW seconds and CYCLES cycles; the last one includes the rest."""
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
