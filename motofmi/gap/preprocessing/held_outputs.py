"""Sensors that are slower than the recording: each of their values is repeated until the next one.

    y_k, y_k, ..., y_k, y_k+1, ...        the same value in each of `length` samples

A signal that is held so is late by half of its sampling interval on average, and a delay of that size would be fitted.
The recording is reduced to the samples at which the sensor has a new value; the other columns pass a low-pass filter.

A quantised signal repeats its values as well, but it changes by one step at a time, or at intervals that depend on its
rate.
"""

from dataclasses import replace

import numpy as np

from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import slower

FEWEST_CHANGES = 100  # of a signal, by which its sampling interval is known
REGULAR = 0.95  # share of the changes at multiples of the interval
ONE_STEP = 1.001  # ratio of the changes of a signal up to which they are steps of one size
NOTE = (
    "{}: {} repeats each of its values in {} samples: the recording is reduced to {:.4g} Hz, the sampling rate of that "
    "sensor"
)


def at_rate_of_outputs(recording: Recording, experiment: InputOutputExperiment) -> tuple[Recording, tuple[str, ...]]:
    """A uniformly sampled recording at the sampling rate of the slowest sensor of an output or an imposed motion, and a
    note where that is not the recording's own."""
    names = [*experiment.outputs, *filter(None, [experiment.imposed])]
    holds = {name: hold_of(recording[name]) for name in names}
    slowest = max(names, key=lambda name: holds[name][0])
    length, first = holds[slowest]
    if length < 2:
        return recording, ()
    kept = slice(first, None)
    begun = replace(recording, time=recording.time[kept], columns={n: y[kept] for n, y in recording.columns.items()})
    reduced = slower(begun, length)
    sampled = {n: begun[n][::length] for n in names if holds[n][0] > 1}
    note = NOTE.format(recording.name, slowest, length, recording.rate / length)
    return replace(reduced, columns={**reduced.columns, **sampled}), (note,)


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
