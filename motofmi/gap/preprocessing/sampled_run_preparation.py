"""The preparation of a recording as a run: checks, resampling, the compared band, intervals between gaps, segments."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.blocks import blocks_of
from motofmi.gap.preprocessing.compared_samples import at_limits, compared_samples
from motofmi.gap.preprocessing.decimation import decimated
from motofmi.gap.preprocessing.flexible_noise_model import Density
from motofmi.gap.preprocessing.free_decay import about_equilibrium, highest_of_motion, is_free
from motofmi.gap.preprocessing.held_signals import at_rate_of_slowest
from motofmi.gap.preprocessing.input_interpolation import INTERPOLATIONS, compared_motion
from motofmi.gap.preprocessing.mains_interference import without_mains_interference
from motofmi.gap.preprocessing.one_way import ONE_WAY, one_way_rates
from motofmi.gap.preprocessing.sampled_run import (
    ACCURACY,
    SHORTEST_SEGMENT,
    SampledRun,
    compared_band,
    interpolated_inputs,
    simulation_steps,
)
from motofmi.gap.preprocessing.undisturbed_intervals import uninterrupted
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import is_white, sensor_noise, uniform
from motofmi.recordings.time_stamps import LATE_STAMPS

FEWEST_SAMPLES = 200
SEGMENT_PERIODS = 6.0  # periods of the motion's mean frequency in a segment
IMPOSED_SEGMENT_PERIODS = 60.0  # the same where a state is imposed: the effect of other initial states decays
END_SHARE = 0.02  # share of a run left out at each end where a motion is imposed: its acceleration is not known there
BAND_OF_MOTION = (
    "{}: compared up to {:.3g} Hz: beyond, the acceleration of the recorded {} is not resolved from its noise or by "
    "its samples"
)


def prepare_sampled_run(recording: Recording, experiment: InputOutputExperiment) -> SampledRun:
    """The run of a recording, with white noise as the initial estimate of its noise.

    Missing and clipped samples are left out of the comparison. Raises InputError for a run that is too short, or an
    output that is constant or white noise that no input explains.
    """
    recorded = len(recording.time)
    recording, bridged = uniform(recording, bridged=1.0)
    recording, held = at_rate_of_slowest(recording, experiment)
    limits, clipping = at_limits(recording.from_zero(), experiment)
    recording, interference = without_mains_interference(recording.from_zero(), experiment.inputs, experiment.outputs)
    recording, notes_of_rate = decimated(recording, experiment)
    elements = experiment.component.elements.values()
    recording, equilibrium = about_equilibrium(recording, experiment.inputs, elements)
    notes = (*bridged, *held, *clipping, *interference, *notes_of_rate, *equilibrium)
    if min(recorded, len(recording.time)) < FEWEST_SAMPLES:
        raise InputError(
            f"{recording.name}: {min(recorded, len(recording.time))} samples are too few to separate noise from a gap; "
            f"expected at least {FEWEST_SAMPLES}; record for longer or with a higher sampling rate, or give several such "
            "recordings of one sampling rate, which are joined"
        )
    for name in experiment.outputs:
        y, unit = recording[name], recording.units[name]
        if np.ptp(y) == 0:
            raise InputError(f"{recording.name}: {name} is constant at {y[0]:g} {unit}; is the sensor connected?")
        if is_white(y, [recording[n] for n in experiment.inputs]):
            raise InputError(
                f"{recording.name}: no excitation: {name} is white noise of {np.std(y):.2g} {unit} (rms), unrelated to "
                "the inputs; record a run in which it moves"
            )
    run = sampled_run(recording, experiment, notes, limits)
    known = [n for n, unknown in zip(experiment.outputs, run.with_offset, strict=True) if not unknown]
    return replace(run, notes=(*run.notes, *(ONE_WAY.format(recording.name, name) for name in known)))


def sampled_run(
    recording: Recording,
    experiment: InputOutputExperiment,
    notes: tuple[str, ...] = (),
    limits: Mapping[str, Sequence[tuple[float, float]]] = MappingProxyType({}),
) -> SampledRun:
    """The run of a recording with equidistant samples, without the checks of `prepare_sampled_run`.

    limits are the times [s] between which outputs, or the imposed motion, are not compared. Raises InputError where
    the intervals between gaps are too short.
    """
    time, rate = recording.time, recording.rate
    measured = np.column_stack([recording[name] for name in experiment.outputs])
    deviations = [sensor_noise(y) for y in measured.T]
    free = is_free(recording, experiment.inputs)
    highest = max(highest_of_motion(y, rate, free) for y in measured.T)
    band = compared_band(highest, rate, len(time))
    if experiment.imposed:
        resolved = compared_motion(recording[experiment.imposed], rate)
        if resolved < band:
            notes = (*notes, BAND_OF_MOTION.format(recording.name, resolved, experiment.imposed))
        highest, band = min(highest, resolved), min(band, resolved)
    margin = int(END_SHARE * len(time)) if experiment.imposed else 0
    intervals = [s for s in uninterrupted(~recording.broken, margin) if s[1] - s[0] >= SHORTEST_SEGMENT // 2]
    if not intervals:
        longest = max(end - begin for begin, end in recording.gaps)
        raise InputError(
            f"{recording.name}: fewer than {SHORTEST_SEGMENT // 2} consecutive samples between its gaps, of up to "
            f"{longest:.3g} s. Reduce it to a rate at which samples are further apart (--rate {1 / longest:.3g}, or "
            f"less), or record without gaps. {LATE_STAMPS}"
        )
    compared = compared_samples(recording, experiment, limits)
    reduction = blocks_of(intervals, len(experiment.outputs), rate, band, compared)
    steps_per_sample = simulation_steps(highest, rate, len(time))
    densities = [
        Density(np.array([0.0, rate / 2]), np.full(2, max(s, ACCURACY * np.std(y)) ** 2))
        for s, y in zip(deviations, measured.T, strict=True)
    ]
    whole = SampledRun(
        recording,
        experiment,
        measured,
        interpolated_inputs(recording, experiment, INTERPOLATIONS[0]),
        intervals,
        segments=intervals,
        steps_per_sample=steps_per_sample,
        reduction=reduction,
        one_way_rates=one_way_rates(recording, experiment.component.elements.values(), free),
        densities=densities,
        noise_source="",
        data=reduction.reduce(measured),
        deviation=reduction.deviations(densities),
        notes=notes,
    )
    periods = IMPOSED_SEGMENT_PERIODS if experiment.imposed else SEGMENT_PERIODS
    return whole.cut(max(int(periods * rate / whole.middle_frequency), SHORTEST_SEGMENT))
