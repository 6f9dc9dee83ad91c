"""Recordings on a regular grid, which spectra need: a few missing samples are bridged, and that is said. The noise in a signal."""

from dataclasses import replace

import numpy as np

from fmus.errors import InputError
from identification.recordings import Recording

BRIDGED = 0.01  # the share of samples that may be interpolated
LEAST_SIGNAL = 5.0  # times its noise: what moves


def uniform(recording: Recording) -> tuple[Recording, tuple[str, ...]]:
    """The recording on a regular grid, and what was done to it.

    Raises InputError where more than a hundredth of the samples is missing.
    """
    time = recording.time
    interval = 1 / recording.rate if np.median(np.diff(time)) > 0 else 0.0
    if interval == 0:
        raise InputError(f"{recording.name}: most time stamps are duplicates; expected a time column [s] that grows")
    steps = np.diff(time)
    if np.all(np.abs(steps - interval) < 0.5 * interval):
        return recording, ()
    count = round((time[-1] - time[0]) / interval) + 1
    missing = count - len(np.unique(np.round((time - time[0]) / interval)))
    if missing > BRIDGED * count:
        raise InputError(f"{recording.name}: {missing} of {count} samples are missing, more than {100 * BRIDGED:g} %; "
                         "cut the recording into parts without gaps")  # fmt: skip
    grid = time[0] + interval * np.arange(count)
    columns = {name: np.interp(grid, time, values) for name, values in recording.columns.items()}
    return replace(recording, time=grid, columns=columns), (f"{missing} missing samples were bridged by straight lines for the spectra",)


def white_noise(y: np.ndarray) -> float:
    """The deviation of white noise in a smooth signal (n,), from its fourth differences; kinks hardly move a median."""
    return float(1.4826 * np.median(np.abs(np.diff(y, 4))) / np.sqrt(70))
