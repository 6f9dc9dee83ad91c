"""Signals that are slower than the recording: each of their values is repeated until the next one.

    y_k, y_k, ..., y_k, y_k+1, ...        the same value in each of `length` samples

An output that is held so is late by half of its sampling interval on average, and a delay of that size would be fitted.
An input is either a command that is held indeed, or the reading of a slower sensor: once only its new values are left,
both are tried as interpolations of the input. The recording is reduced to the samples at which the slowest signal has a
new value; columns that are not held pass a low-pass filter.

A quantised signal repeats its values as well, but it changes by one step at a time, or at intervals that depend on its
rate. An input in steps that are long against the motion is no slow sensor.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.decimation import OVERSAMPLING_OF_MOTION
from motofmi.gap.preprocessing.free_decay import highest_of_motion, is_free
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import slower

FEWEST_CHANGES = 100  # of a signal, by which its sampling interval is known
REGULAR = 0.95  # share of the changes at multiples of the interval
ONE_STEP = 1.001  # ratio of the changes of a signal up to which they are steps of one size
NOTE = (
    "{}: {} repeats each of its values in {} samples: the recording is reduced to {:.4g} Hz, the sampling rate of that "
    "signal"
)


BETWEEN = "{}: {} repeats each of its values in {} samples: it is interpolated between its new ones"


def between_new_values(recording: Recording, sensors: Sequence[str]) -> tuple[Recording, tuple[str, ...]]:
    """A uniformly sampled recording whose sensors are interpolated between their new values where they repeat them, and
    a note on each that does. Its rate is kept."""
    holds = {name: hold for name in sensors if (hold := hold_of(recording[name]))[0] > 1}
    columns = {name: _through_new_values(recording[name], hold) for name, hold in holds.items()}
    notes = tuple(BETWEEN.format(recording.name, name, length) for name, (length, _) in holds.items())
    return replace(recording, columns={**recording.columns, **columns}), notes


def at_rate_of_slowest(recording: Recording, experiment: InputOutputExperiment) -> tuple[Recording, tuple[str, ...]]:
    """A uniformly sampled recording at the sampling rate of its slowest output, imposed motion, or input that is fast
    against the outputs, and a note where that is not the recording's own."""
    outputs = [n for n in (*experiment.outputs, experiment.imposed) if n and np.ptp(recording[n]) > 0]
    free, rate = is_free(recording, experiment.inputs), recording.rate
    if not outputs:
        return recording, ()
    highest = max(highest_of_motion(recording[n], rate, free) for n in outputs)
    holds = {name: hold_of(recording[name]) for name in dict.fromkeys((*outputs, *experiment.inputs))}
    resolved = {n: hold for n, hold in holds.items() if n in outputs or rate / hold[0] >= OVERSAMPLING_OF_MOTION * highest}
    slowest = max(resolved, key=lambda name: resolved[name][0])
    length, first = holds[slowest]
    if length < 2:
        return recording, ()
    kept = slice(first, None)
    begun = replace(recording, time=recording.time[kept], columns={n: y[kept] for n, y in recording.columns.items()})
    reduced = slower(begun, length)
    slow = {name: hold for name, hold in resolved.items() if hold[0] > 1}
    sampled = {name: _through_new_values(recording[name], hold)[kept][::length] for name, hold in slow.items()}
    note = NOTE.format(recording.name, slowest, length, rate / length)
    return replace(reduced, columns={**reduced.columns, **sampled}), (note,)


def _through_new_values(values: np.ndarray, hold: tuple[int, int]) -> np.ndarray:
    """A signal (n,) interpolated between the samples at which it has new values."""
    length, first = hold
    new = np.arange(first, len(values), length)
    return CubicSpline(new, values[new])(np.arange(len(values)))


def hold_of(values: np.ndarray) -> tuple[int, int]:
    """In how many samples a signal (n,) repeats each of its values, and the first sample with a new one; 1 and 0 for a
    signal that does not."""
    changes = np.flatnonzero(np.diff(values)) + 1
    if len(changes) < FEWEST_CHANGES:
        return 1, 0
    length = int(np.median(np.diff(changes)))
    first = int(np.bincount(changes % length).argmax())
    sizes = np.abs(np.diff(values)[changes - 1])
    one_size = np.quantile(sizes, REGULAR) <= ONE_STEP * np.quantile(sizes, 1 - REGULAR)
    regular = np.mean((changes - first) % length == 0) >= REGULAR
    return (length, first) if regular and not one_size else (1, 0)
