"""The decimation of recordings whose sampling rate is far above the frequencies of what is compared."""

from collections.abc import Sequence

import numpy as np

from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.free_decay import highest_of_motion, is_free, nearly_highest
from motofmi.gap.preprocessing.input_interpolation import compared_motion
from motofmi.gap.preprocessing.sampled_run import SampledRun, compared_band
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import slower

OVERSAMPLING = 20  # sampling rate over the highest frequency above which a recording is decimated
# The same where a motion is imposed: its spline is then accurate within 1.4 % at that frequency, where 10 % of the
# acceleration's amplitude is noise.
OVERSAMPLING_OF_MOTION = 8
MOST_SAMPLES = 6000  # samples above which a recording is decimated
MANY_SAMPLES = 20_000  # of all runs together, above which the search may take more than a minute


def decimated(recording: Recording, experiment: InputOutputExperiment) -> tuple[Recording, tuple[str, ...]]:
    """The recording at a lower rate, where its rate is far above the highest frequency of what is compared: of the
    outputs, and of an imposed motion that is resolved.

    An input may have higher frequencies: a low-pass filter commutes with the linear part of the component, and what an
    input beyond ten times the band of the outputs does to them is below their noise.
    """
    wanted = [*experiment.outputs, *filter(None, [experiment.imposed])]
    moving = [recording[n] for n in wanted if np.ptp(recording[n]) > 0]
    free = is_free(recording, experiment.inputs)
    highest = max((highest_of_motion(y, recording.rate, free) for y in moving), default=recording.rate)
    oversampling = OVERSAMPLING
    if experiment.imposed:
        band = compared_band(highest, recording.rate, len(recording.time))
        highest = min(band, compared_motion(recording[experiment.imposed], recording.rate))
        oversampling = OVERSAMPLING_OF_MOTION
    factor = int(recording.rate / (oversampling * highest))
    if factor < 2 or len(recording.time) < MOST_SAMPLES:
        return recording, ()
    factor = min(factor, len(recording.time) // (MOST_SAMPLES // 2))
    note = (
        f"{recording.name}: decimated to {recording.rate / factor:.4g} Hz; the highest frequency that is compared is "
        f"{highest:.3g} Hz"
    )
    return slower(recording, factor), (note,)


def advice_on_rate(runs: Sequence[SampledRun]) -> str:
    """The sentence on runs with many samples whose outputs have little power at high frequencies; empty without them.

    Such runs were not decimated, since their outputs exceed the noise at high frequencies, too.
    """
    samples = sum(len(run.measured) for run in runs)
    highest = max(nearly_highest(y, run.recording.rate) for run in runs for y in run.measured.T)
    rate = float(f"{OVERSAMPLING * highest:.2g}")
    if samples <= MANY_SAMPLES or rate > min(run.recording.rate for run in runs) / 2:
        return ""
    return (
        f"The search over {samples} samples may take minutes. 99.9 % of the variance of the outputs lies below "
        f"{highest:.3g} Hz: --rate {rate:g} reduces the samples; --time limits the search."
    )
