"""Recordings on a regular grid, which spectra need, with a few missing samples bridged; at a lower rate; the
white noise in a signal."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import chdtri

from fmus.support.errors import InputError
from motofmi.recordings.recording import Recording
from motofmi.recordings.time_stamps import coarse, complete, holes, interval, places, regular_grid

BRIDGED = 0.01  # largest share of samples that may be interpolated
SHORT = 3  # longest gap that is interpolated by a spline, in samples; longer gaps by a straight line
LONG = 1.5  # sampling intervals between two samples above which a sample is missing
HALF = 0.5  # largest delay of a time stamp of a regular clock, in sampling intervals
EXACT = 1e-3  # deviation from a regular grid up to which stamps are not corrected, in sampling intervals
SMOOTHER = (
    0.95  # of the white noise: resampling at the stamps must reduce it to this for the stamps to be taken as true
)
AT_LEVELS = 0.9  # share of the samples of a quantised signal that are at recurring levels
FEWEST_LEVELS = 10  # of a quantised signal; one with fewer, such as that of a valve, is no measurement of a motion
LAGS, LEVEL = 20, 0.001  # samples and significance level of the test for white noise
ROUNDING = 1e-9  # change of a signal over its largest value [1], up to which it is constant
LEAST_SIGNAL = 5.0  # smallest standard deviation of a signal with motion, in standard deviations of its noise


def uniform(recording: Recording, bridged: float = BRIDGED) -> tuple[Recording, tuple[str, ...]]:
    """The recording on a regular grid, and what was done to it.

    Where no sample is missing, stamps that are rounded or late are replaced; samples that were taken off the grid, and
    those of an irregular clock, are interpolated onto it. Raises InputError where more than the share `bridged` of the
    samples is missing.
    """
    time = recording.time
    if interval(time) == 0:
        raise InputError(f"{recording.name}: most time stamps are duplicates; expected a time column [s] that grows")
    if not coarse(time) and not np.all(np.diff(time) > 0):
        recording = _rows(recording, np.unique(time, return_index=True)[1])
        time = recording.time
    if complete(time):
        return _stamped_anew(recording, regular_grid(time, np.arange(len(time))))
    taken = places(time)
    if taken is None:
        return _regular(recording)
    count = int(taken[-1]) + 1
    missing = count - len(taken)
    if missing > bridged * count:
        raise InputError(f"{recording.name}: {missing} of {count} samples are missing, more than {100 * bridged:g} %; "
                         "cut the recording into parts without gaps")  # fmt: skip
    grid = regular_grid(time, taken)
    made = _bridged(recording, taken.astype(float), grid, grid[taken])
    return made, (
        f"{recording.name}: {missing} missing samples were bridged, more than {SHORT} in a row by straight lines",
    )


def _rows(recording: Recording, rows: np.ndarray) -> Recording:
    return replace(recording, time=recording.time[rows], columns={n: y[rows] for n, y in recording.columns.items()})


def _regular(recording: Recording) -> tuple[Recording, tuple[str, ...]]:
    """The recording of an irregular clock, interpolated between its samples onto a grid of their mean interval."""
    time, away = recording.time, holes(recording.time, SHORT + 1)
    steps = np.diff(time)
    step = float(np.delete(steps, away).mean())
    grid = time[0] + step * np.arange(int(np.ptp(time) / step * (1 + 1e-9)) + 1)
    made = replace(_bridged(recording, (time - time[0]) / step, grid, time), bridged=())
    gaps = f"; {len(away)} gaps, the longest of {steps.max():.3g} s, are left out" if len(away) else ""
    low, high = np.quantile(np.delete(steps, away), [0.01, 0.99])
    return made, (
        f"{recording.name}: time stamps jitter (steps of {1e3 * low:.3g} to {1e3 * high:.3g} ms, 98 % of them): the "
        f"samples were interpolated onto a regular grid of {1e3 * step:.4g} ms{gaps}",
    )


def _bridged(recording: Recording, at: np.ndarray, grid: np.ndarray, stamps: np.ndarray) -> Recording:
    """The recording on a grid (m,), from samples at `at` (n,) in intervals of it, stamped (n,): splines between
    samples, straight lines over gaps."""
    every, steps = np.arange(len(grid)), np.diff(at)
    before = np.clip(np.searchsorted(at, every, side="right") - 1, 0, len(steps) - 1)
    smooth, columns = steps[before] <= SHORT + 1, {}
    for name, values in recording.columns.items():
        lines = np.interp(every, at, values)
        columns[name] = np.where(smooth, CubicSpline(at, values)(every), lines)
    wide = {True: steps > SHORT + 1, False: (steps > LONG) & (steps <= SHORT + 1)}
    ends = {long: tuple((float(stamps[i]), float(stamps[i + 1])) for i in np.flatnonzero(w))
            for long, w in wide.items()}
    return replace(recording, time=grid, columns=columns, gaps=ends[True], bridged=ends[False])


def _stamped_anew(recording: Recording, grid: np.ndarray) -> tuple[Recording, tuple[str, ...]]:
    """The recording with the stamps of a grid (n,); its samples are interpolated onto it if that
    reduces their white noise.

    A stamp that is late belongs to its own place on the grid. Stamps further than half an interval off belong to a
    clock that is not regular.
    """
    late = recording.time - grid
    late -= np.median(late)
    off, step = float(np.max(np.abs(late))), float(grid[1] - grid[0])
    if off < EXACT * step:
        return recording, ()
    if np.all(np.diff(recording.time) > 0):
        if off > HALF * step and places(recording.time) is None:
            return _regular(recording)
        interpolated = replace(
            recording,
            time=grid,
            columns={n: CubicSpline(recording.time, y)(grid) for n, y in recording.columns.items()},
        )
        ratios = [white_noise(interpolated[n]) / white_noise(y)
                  for n, y in recording.columns.items() if white_noise(y) > 0]
        if ratios and np.mean(np.log(np.maximum(ratios, 1e-3))) < np.log(SMOOTHER):
            return interpolated, (
                f"{recording.name}: the samples, taken up to {1e3 * off:.2g} ms off a regular grid, were interpolated "
                "onto it",
            )
    return replace(recording, time=grid), (
        f"{recording.name}: time stamps, rounded or late by up to {1e3 * off:.2g} ms, were replaced by a regular grid",
    )


def slower(recording: Recording, factor: int) -> Recording:
    """The recording on a regular grid with one of `factor` samples kept, low-pass filtered at four fifths
    of half its new rate."""
    from scipy.signal import resample_poly  # noqa: PLC0415 - imported on use: it takes 0.5 s

    columns = {name: resample_poly(y, 1, factor, padtype="line") for name, y in recording.columns.items()}
    return replace(recording, time=recording.time[::factor], columns=columns)


def varies(values: np.ndarray) -> bool:
    """Whether a signal (n,) changes by more than the rounding of its interpolation."""
    return float(np.ptp(values)) > ROUNDING * float(np.max(np.abs(values), initial=0.0))


def white_noise(y: np.ndarray) -> float:
    """The deviation of white noise in a smooth signal (n,), from its fourth differences; kinks hardly move a median."""
    return float(1.4826 * np.median(np.abs(np.diff(y, 4))) / np.sqrt(70))


def quantisation_step(y: np.ndarray) -> float:
    """The step between the levels of a signal (n,) whose quantisation exceeds its noise, such as an encoder's; else 0.

    Nearly all its samples are at levels that recur; values that were interpolated or are continuous do not recur.
    """
    values, counts = np.unique(y, return_counts=True)
    recurring = counts > 1
    if np.sum(recurring) < FEWEST_LEVELS or np.sum(counts[recurring]) < AT_LEVELS * len(y):
        return 0.0
    return float(np.median(np.diff(values[recurring])))


def sensor_noise(y: np.ndarray) -> float:
    """The deviation of white noise in a smooth signal (n,), at least that of its quantisation.

    A level that lasts for several samples has no fourth difference, but an error uniform over a step q, of deviation
    q / sqrt(12).

    Source: Widrow, Kollar, Quantization Noise (2008), ch. 5.
    """
    return max(white_noise(y), quantisation_step(y) / np.sqrt(12))


def is_white(y: np.ndarray, others: Sequence[np.ndarray] = ()) -> bool:
    """Whether a signal (n,) is white noise that is unrelated to others (n,) up to LAGS samples before.

    Source: Ljung, Box, Biometrika 65 (1978) 297-303.
    """
    n = len(y)
    size = 2 * n
    spectrum = np.fft.rfft(y - y.mean(), size)
    limit = chdtri(LAGS, LEVEL)
    for other in (y, *(each for each in others if np.ptp(each) > 0)):
        scale = n * np.std(y) * np.std(other)
        related = np.fft.irfft(spectrum * np.conj(np.fft.rfft(other - other.mean(), size)), size)[1 : LAGS + 1] / scale
        if n * (n + 2) * np.sum(related**2 / (n - np.arange(1, LAGS + 1))) > limit:
            return False
    return True
