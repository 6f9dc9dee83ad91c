"""A planned run: the commanded motion, the outputs that a model predicts for it, and the noise of the rig.

It is prepared as a recording is, so that its standard deviations are those of the run when it is made.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from motofmi.frequency_response.excitation import Excitation
from motofmi.gap.preprocessing.harmonics import noise_of
from motofmi.gap.preprocessing.steer_test_run import SteerTestRun, prepare_steer_test_run
from motofmi.recordings.channels import units_of
from motofmi.recordings.recording import Recording


@dataclass(frozen=True)
class Channels:
    """The sensors of a rig: sampling rate [Hz], standard deviation of the motion's noise, noise density of the effort.

    The density is the variance per sample at a frequency [Hz]: white noise of standard deviation s has the density s^2.
    further holds the standard deviations of other sensors' white noise by column.
    """

    rate: float
    motion_noise: float
    density: Callable[[np.ndarray], np.ndarray]
    further: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, run: SteerTestRun, imposed: str) -> "Channels":
        """The sensors estimated from an existing run."""
        white = np.median(noise_of(run.reduction, run.recording[imposed]).density)
        further = {output.column: float(np.sqrt(np.median(output.noise.density))) for output in run.outputs[1:]}
        return cls(run.recording.rate, float(np.sqrt(white)), run.effort.noise, further)


def planned(
    excitation: Excitation,
    channels: Channels,
    columns: Mapping[str, str],
    predict: Callable[[SteerTestRun], np.ndarray],
    seed: int = 0,
) -> SteerTestRun:
    """The run with this excitation, where `predict` gives the outputs (n, ny) for its motion.

    columns maps imposed, measured and command to columns of recordings. Raises InputError as
    `prepare_steer_test_run` does.
    """
    imposed, measured, command = columns["imposed"], columns["measured"], columns["command"]
    rng = np.random.default_rng(seed)
    time = np.arange(round(excitation.duration * channels.rate)) / channels.rate
    angle, _ = excitation.motion(time)
    noise = np.column_stack(
        [_coloured(channels, len(time), rng), *(s * rng.standard_normal(len(time)) for s in channels.further.values())]
    )
    measured_angle = angle + channels.motion_noise * rng.standard_normal(len(time))

    outputs = (measured, *channels.further)
    table = {imposed: measured_angle, command: angle, **dict(zip(outputs, noise.T, strict=True))}
    recording = Recording(excitation.name, time, table, units_of(table))
    noise_only = prepare_steer_test_run(recording, imposed, measured, command, tuple(channels.further))
    kept = noise_only.recording  # at the rate at which it is compared
    with_outputs = {column: y + kept[column] for column, y in zip(outputs, predict(noise_only).T, strict=True)}
    return prepare_steer_test_run(
        replace(kept, columns=kept.columns | with_outputs), imposed, measured, command, tuple(channels.further)
    )


def _coloured(channels: Channels, n: int, rng: np.random.Generator) -> np.ndarray:
    """Noise (n,) with the density of the effort's channel."""
    shape = np.sqrt(channels.density(np.fft.rfftfreq(n, 1 / channels.rate)))
    return np.fft.irfft(np.fft.rfft(rng.standard_normal(n)) * shape, n)
