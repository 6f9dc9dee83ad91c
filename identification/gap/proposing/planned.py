"""A run that has not been made: the motion that would be commanded, what a model would answer, and the rig's own noises.

It passes through the same preparation as a recording, so that its deviations are those that the run would have.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from identification.excitation import Excitation
from identification.gap.data.reduction import noise_of
from identification.gap.data.runs import Run, prepare
from identification.recordings import QUANTITIES, Recording


@dataclass(frozen=True)
class Channels:
    """How a rig measures: samples per second, the deviation of the motion's noise, the spectrum of the effort's.

    The density is a variance per sample at a frequency [Hz]: white noise of deviation s has density s^2. further are the
    deviations of other sensors' white noise by column.
    """

    rate: float
    motion_noise: float
    density: Callable[[np.ndarray], np.ndarray]
    further: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, run: Run, imposed: str) -> "Channels":
        """The channels as a run that was made shows them."""
        white = np.median(noise_of(run.reduction, run.recording[imposed]).density)
        further = {output.column: float(np.sqrt(np.median(output.noise.density))) for output in run.outputs[1:]}
        return cls(run.recording.rate, float(np.sqrt(white)), run.effort.noise, further)


def planned(excitation: Excitation, channels: Channels, columns: Mapping[str, str], answer: Callable[[Run], np.ndarray], seed: int = 0) -> Run:
    """The run with this excitation, where `answer` gives the outputs (n, ny) for its motion.

    columns maps imposed, measured and command to columns of recordings. Raises InputError as `prepare` does.
    """
    imposed, measured, command = columns["imposed"], columns["measured"], columns["command"]
    rng = np.random.default_rng(seed)
    time = np.arange(round(excitation.duration * channels.rate)) / channels.rate
    angle, _ = excitation.motion(time)
    noise = np.column_stack([_coloured(channels, len(time), rng), *(s * rng.standard_normal(len(time)) for s in channels.further.values())])
    shown = angle + channels.motion_noise * rng.standard_normal(len(time))

    outputs = (measured, *channels.further)
    table = {imposed: shown, command: angle, **dict(zip(outputs, noise.T, strict=True))}
    recording = Recording(excitation.name, time, table, {column: QUANTITIES[column] for column in table})
    still = prepare(recording, imposed, measured, command, tuple(channels.further))
    kept = still.recording  # at the rate at which it is compared
    answered = {column: y + kept[column] for column, y in zip(outputs, answer(still).T, strict=True)}
    return prepare(replace(kept, columns=kept.columns | answered), imposed, measured, command, tuple(channels.further))


def _coloured(channels: Channels, n: int, rng: np.random.Generator) -> np.ndarray:
    """Noise (n,) with the density of the effort's channel."""
    shape = np.sqrt(channels.density(np.fft.rfftfreq(n, 1 / channels.rate)))
    return np.fft.irfft(np.fft.rfft(rng.standard_normal(n)) * shape, n)
