"""Which samples of a run are compared: not missing ones, and not those at a limit of a sensor or stop."""

from collections.abc import Mapping, Sequence

import numpy as np

from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.recordings.quality import clipped, is_steady
from motofmi.recordings.recording import Recording


def at_limits(
    recording: Recording, experiment: InputOutputExperiment
) -> tuple[dict[str, list[tuple[float, float]]], tuple[str, ...]]:
    """The times [s] between which each output, or the imposed motion, stays at a limit, and notes on them."""
    found: dict[str, list[tuple[float, float]]] = {}
    notes = []
    inputs = [recording[name] for name in experiment.inputs]
    for name in dict.fromkeys([*experiment.outputs, *filter(None, [experiment.imposed])]):
        y, time = recording[name], recording.time
        for sign in (1.0, -1.0):
            at = clipped(sign * y)
            if not len(at) or (name != experiment.imposed and is_steady(at, inputs)):
                continue
            beside = np.concatenate([[-np.inf], time, [np.inf]])
            ends = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
            found.setdefault(name, []).extend((float(beside[e[0]]), float(beside[e[-1] + 2])) for e in ends)
            notes.append(
                f"{recording.name}: {len(at)} samples of {name} at its limit of {y[at[0]]:.4g} {recording.units[name]} "
                "are left out of the comparison: the sensor or a stop may clip them"
            )
    return found, tuple(notes)


def compared_samples(
    recording: Recording, experiment: InputOutputExperiment, limits: Mapping[str, Sequence[tuple[float, float]]]
) -> np.ndarray | None:
    """Which samples (n, outputs) are neither bridged nor at a limit; None where all are compared."""
    everywhere = [*recording.bridged, *limits.get(experiment.imposed, ())]
    left_out = [recording.within([*everywhere, *limits.get(name, ())]) for name in experiment.outputs]
    return ~np.column_stack(left_out) if np.any(left_out) else None
