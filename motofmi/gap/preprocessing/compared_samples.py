"""Which samples of a run are compared: not missing ones, and not those at a limit of a sensor or stop."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.recordings.quality import clipped
from motofmi.recordings.recording import Recording

SETTLING = 50  # samples; inputs that are constant for less may be the steps of a digital controller


def at_limits(
    recording: Recording, experiment: InputOutputExperiment
) -> tuple[dict[str, list[tuple[float, float]]], tuple[str, ...]]:
    """The times [s] between which each output, or the imposed motion, stays at a limit, and notes on them."""
    found: dict[str, list[tuple[float, float]]] = {}
    notes = []
    inputs = np.array([recording[name] for name in experiment.inputs if np.ptp(recording[name]) > 0])
    for name in dict.fromkeys([*experiment.outputs, *filter(None, [experiment.imposed])]):
        y, time = recording[name], recording.time
        for sign in (1.0, -1.0):
            at = clipped(sign * y)
            if not len(at) or (name != experiment.imposed and _is_steady(at, inputs)):
                continue
            beside = np.concatenate([[-np.inf], time, [np.inf]])
            ends = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
            found.setdefault(name, []).extend((float(beside[e[0]]), float(beside[e[-1] + 2])) for e in ends)
            notes.append(
                f"{recording.name}: {len(at)} samples of {name} at its limit of {y[at[0]]:.4g} {recording.units[name]} "
                "are left out of the comparison: the sensor or a stop may clip them"
            )
    return found, tuple(notes)


def _is_steady(at: np.ndarray, inputs: np.ndarray) -> bool:
    """Whether most of the samples (k,) at a limit are steady values: in the second half of a long stretch over which all
    inputs (inputs, n) are constant the output is still there, where a motion beyond a limit would come back."""
    if not len(inputs):
        return False
    changes = np.flatnonzero(np.any(np.diff(inputs) != 0, axis=0)) + 1
    steady = 0
    for first, last in pairwise([0, *changes.tolist(), inputs.shape[1]]):
        inside = at[(at >= first) & (at < last)]
        if last - first >= SETTLING and np.count_nonzero(inside >= (first + last) / 2) > len(inside) / 2:
            steady += len(inside)
    return steady > len(at) / 2


def compared_samples(
    recording: Recording, experiment: InputOutputExperiment, limits: Mapping[str, Sequence[tuple[float, float]]]
) -> np.ndarray | None:
    """Which samples (n, outputs) are neither bridged nor at a limit; None where all are compared."""
    everywhere = [*recording.bridged, *limits.get(experiment.imposed, ())]
    left_out = [recording.within([*everywhere, *limits.get(name, ())]) for name in experiment.outputs]
    return ~np.column_stack(left_out) if np.any(left_out) else None
