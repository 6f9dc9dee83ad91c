"""Recordings on a regular grid, which spectra need: a few missing samples are bridged, and that is said. Slower ones. The noise in a signal."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import resample_poly

from fmus.errors import InputError
from identification.recordings import Recording
from identification.time_stamps import complete, interval

BRIDGED = 0.01  # the share of samples that may be interpolated
SHORT = 3  # samples in a row that a spline bridges
EXACT = 1e-3  # of the interval: stamps that are nearer to a regular grid are as good as on it
SMOOTHER = 0.95  # of the noise: what moving samples must leave for their stamps to be believed
LEAST_SIGNAL = 5.0  # times its noise: what moves


def uniform(recording: Recording) -> tuple[Recording, tuple[str, ...]]:
    """The recording on a regular grid, and what was done to it.

    Where no sample is missing, stamps that are rounded or late are replaced; samples that were truly taken off the grid are moved.
    Raises InputError where more than a hundredth of the samples is missing.
    """
    time, step = recording.time, interval(recording.time)
    if step == 0:
        raise InputError(f"{recording.name}: most time stamps are duplicates; expected a time column [s] that grows")
    if complete(time):
        return _stamped_anew(recording, time[0] + step * np.arange(len(time)))
    places, rows = np.unique(np.round((time - time[0]) / step).astype(int), return_index=True)
    count = int(places[-1]) + 1
    missing = count - len(places)
    if missing > BRIDGED * count:
        raise InputError(f"{recording.name}: {missing} of {count} samples are missing, more than {100 * BRIDGED:g} %; "
                         "cut the recording into parts without gaps")  # fmt: skip
    every = np.arange(count)
    smooth = np.diff(places)[np.searchsorted(places, every[1:]) - 1] <= SHORT + 1
    columns = {name: np.interp(every, places, values[rows]) for name, values in recording.columns.items()}
    for name, values in recording.columns.items():
        columns[name][1:][smooth] = CubicSpline(places, values[rows])(every[1:])[smooth]
    grid, long = time[0] + step * every, np.flatnonzero(np.diff(places) > SHORT + 1)
    gaps = tuple((float(grid[places[i]]), float(grid[places[i + 1]])) for i in long)
    return replace(recording, time=grid, columns=columns, gaps=gaps), (f"{missing} missing samples were bridged, more than {SHORT} in a row by straight lines",)


def _stamped_anew(recording: Recording, grid: np.ndarray) -> tuple[Recording, tuple[str, ...]]:
    """The recording with the stamps of a grid (n,); its samples are moved onto it if that makes them smoother."""
    late = recording.time - grid
    off = float(np.max(np.abs(late - np.median(late))))
    if off < EXACT * (grid[1] - grid[0]):
        return recording, ()
    if np.all(np.diff(recording.time) > 0):
        moved = replace(recording, time=grid, columns={n: CubicSpline(recording.time, y)(grid) for n, y in recording.columns.items()})
        ratios = [white_noise(moved[n]) / white_noise(y) for n, y in recording.columns.items() if white_noise(y) > 0]
        if ratios and np.mean(np.log(np.maximum(ratios, 1e-3))) < np.log(SMOOTHER):
            return moved, (f"{recording.name}: the samples, taken up to {1e3 * off:.2g} ms off a regular grid, were moved onto it",)
    return replace(recording, time=grid), (f"{recording.name}: time stamps, rounded or late by up to {1e3 * off:.2g} ms, were replaced by a regular grid",)


def slower(recording: Recording, factor: int) -> Recording:
    """The recording on a regular grid with every so many samples kept; what is faster than four fifths of half its new rate fades out."""
    columns = {name: resample_poly(y, 1, factor, padtype="line") for name, y in recording.columns.items()}
    return replace(recording, time=recording.time[::factor], columns=columns)


def white_noise(y: np.ndarray) -> float:
    """The deviation of white noise in a smooth signal (n,), from its fourth differences; kinks hardly move a median."""
    return float(1.4826 * np.median(np.abs(np.diff(y, 4))) / np.sqrt(70))
