r"""Recorded runs in which not all states are measured, prepared for one-step prediction.

Disturbances that are not recorded excite the vehicle; under closed-loop control the inputs depend on them too. The
one-step prediction error of the right model is independent of all earlier data in both cases. Errors are compared as
cosine coefficients of blocks, at all frequencies above those of offsets and drift.

Source: Ljung, System Identification, 2nd ed. (1999), ch. 7 and 13.4.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.fft import dct

from fmus.support.errors import InputError
from motofmi.gap.preprocessing.flexible_noise_model import Density
from motofmi.gap.preprocessing.held_signals import between_new_values
from motofmi.gap.preprocessing.undisturbed_intervals import (
    BLOCK,
    FEWEST_BLOCKS,
    note_on_blocks,
    too_few_blocks,
    undisturbed,
)
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import uniform, white_noise

RATE = 80.0  # Hz: samples of faster recordings are averaged, down to this rate or a little above
EXCITATION_RATIO = 2.0  # least standard deviation of an output over its noise in a run with excitation
SETTLING_TIME = 3.0  # s at the start of an interval in which the effect of the initial state decays
# Hz: errors are compared from there to half the sampling rate. With an upper limit a fit could shift errors to
# frequencies above it.
LOWEST_FREQUENCY = 0.3
SPEED_STEP = 0.04  # relative distance of the speeds for which matrices are computed
CONSTANT_SPEED = 0.005  # relative range within which the speed is constant


@dataclass(frozen=True, repr=False)
class PredictedRun:
    """A run: compared outputs and recorded inputs, `factor` samples averaged to one, in intervals [first, last).

    over is the channel of the speed [m/s]. noise (k,) holds the magnitudes of disturbances and sensor noise (see
    `models.disturbances`). mixing (ny, ny) and densities transform prediction errors to independent numbers of standard
    deviation 1.
    """

    recording: Recording
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    over: str
    factor: int
    intervals: tuple[tuple[int, int], ...]
    noise: np.ndarray | None = None
    mixing: np.ndarray | None = None
    densities: tuple[Density, ...] = ()
    held: bool = False  # whether inputs are held between samples (zero-order hold), as by a digital controller
    unit: str = "1"
    notes: tuple[str, ...] = ()
    motion: Mapping[str, np.ndarray] = field(default_factory=dict, compare=False)  # the vehicle's predicted states (n,)

    def __repr__(self) -> str:
        inputs, outputs = (", ".join(names) or "none" for names in (self.inputs, self.outputs))
        return f"PredictedRun({self.name!r}, {len(self.recording.time)} samples, inputs {inputs}, outputs {outputs})"

    @property
    def name(self) -> str:
        """The name of the recording."""
        return self.recording.name

    @property
    def step(self) -> float:
        """The time between two averaged samples [s]."""
        return self.factor / self.recording.rate

    @cached_property
    def measured(self) -> np.ndarray:
        """The outputs (n, ny)."""
        return np.column_stack([self.averaged(self.recording[n]) for n in self.outputs])

    def averaged(self, values: np.ndarray) -> np.ndarray:
        """The mean of every `factor` samples of (..., N): (..., n)."""
        n = values.shape[-1] // self.factor
        return values[..., : n * self.factor].reshape(*values.shape[:-1], n, self.factor).mean(axis=-1)

    @property
    def exactly_held(self) -> bool:
        """Whether inputs are held between the averaged samples; an average over several held samples is not."""
        return self.held and self.factor == 1

    def interpolable(self, values: np.ndarray) -> np.ndarray:
        """An input (N,) as averaged values (n,) for a prediction that interpolates linearly between them.

        The mean error of linear interpolation of a smooth signal is its curvature times h^2 / 12; it is subtracted.
        """
        if self.exactly_held:
            return values
        if self.held:
            values = (values + np.concatenate([values[:1], values[:-1]])) / 2
        u = self.averaged(values)
        return u - np.convolve(np.pad(u, 1, mode="edge"), [1, -2, 1], "valid") / 12

    @cached_property
    def speeds(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The speeds (g,) [m/s] for which matrices are computed, and the position of every sample among them.

        The position is the index (n,) of the next lower speed, and the weight (n,) of the next higher one.
        """
        speed = self.averaged(self.recording[self.over])
        width = max(int(1 / (self.step * 2)), 1)
        smooth = np.convolve(np.pad(speed, width, mode="edge"), np.ones(2 * width + 1) / (2 * width + 1), "valid")
        within = np.concatenate([smooth[a:b] for a, b in self.intervals])
        low, high = np.quantile(within, [0.01, 0.99])
        mean = float(within.mean())
        if high - low < CONSTANT_SPEED * mean:
            return np.array([mean]), np.zeros(len(speed), np.int64), np.zeros(len(speed))
        grid = np.linspace(low, high, int(np.ceil((high - low) / (SPEED_STEP * mean))) + 1)
        at = np.clip((smooth - grid[0]) / (grid[1] - grid[0]), 0, len(grid) - 1 - 1e-9)
        return grid, at.astype(np.int64), at - np.floor(at)

    @cached_property
    def blocks(self) -> np.ndarray:
        """The first samples (blocks,) of the blocks."""
        settling = int(SETTLING_TIME / self.step)
        starts = (range(a + settling, b - self.length + 1, self.length) for a, b in self.intervals)
        return np.array([start for interval in starts for start in interval], int)

    @cached_property
    def compared(self) -> np.ndarray:
        """The indices (m,) of the samples that are compared: those of all blocks."""
        return (self.blocks[:, None] + np.arange(self.length)).ravel()

    @property
    def length(self) -> int:
        """The number of samples of a block."""
        return int(BLOCK / self.step)

    @cached_property
    def frequency(self) -> np.ndarray:
        """The frequencies (k,) that are compared [Hz]."""
        every = np.arange(self.length) / (2 * self.length * self.step)
        return every[every >= LOWEST_FREQUENCY]

    def cosines(self, errors: np.ndarray) -> np.ndarray:
        """The cosine coefficients (ny, blocks, k, ...) of errors (n, ny, ...), in independent mixtures of outputs."""
        assert self.mixing is not None
        taken = errors[self.blocks[:, None] + np.arange(self.length)]
        orders = np.round(self.frequency * 2 * self.length * self.step).astype(int)
        spectrum = dct(taken, axis=1, norm="ortho")[:, orders]
        return np.einsum("ij,bkj...->ibk...", self.mixing, spectrum)

    def whitened(self, errors: np.ndarray) -> np.ndarray:
        """Errors (n, ny, ...) over time as numbers (m, ...) of standard deviation 1."""
        parts = self.cosines(errors)
        deviation = np.sqrt(np.stack([d(self.frequency) for d in self.densities]))[:, None, :]
        parts = parts / deviation.reshape(*deviation.shape, *[1] * (parts.ndim - 3))
        return parts.reshape(-1, *parts.shape[3:])

    @cached_property
    def data(self) -> np.ndarray:
        """Zeros (m,): the errors of a perfect prediction."""
        return np.zeros(len(self.outputs) * len(self.blocks) * len(self.frequency))

    @cached_property
    def deviation(self) -> np.ndarray:
        """Ones (m,): the standard deviation of whitened errors."""
        return np.ones_like(self.data)

    def with_noise(self, noise: np.ndarray, motion: Mapping[str, np.ndarray]) -> "PredictedRun":
        """The run with these magnitudes of disturbances and sensor noise, and the motion that is then predicted."""
        return replace(self, noise=noise, motion=motion)

    def with_floor(self, mixing: np.ndarray, densities: Sequence[Density]) -> "PredictedRun":
        """The run with the covariance and the spectra of the errors of its best prediction."""
        return replace(self, mixing=mixing, densities=tuple(densities))


def prepare_predicted_run(
    recording: Recording, over: str, outputs: Sequence[str], inputs: Sequence[str]
) -> PredictedRun:
    """The run without the intervals in which the vehicle starts, stops or falls, and without outliers.

    over is the channel of the speed [m/s]. The noise is not estimated yet. Raises InputError where fewer than two
    undisturbed blocks remain, an output is constant, or all outputs are consistent with their noise.
    """
    recording, notes = uniform(recording)
    recording, held = between_new_values(recording, outputs)
    notes = (*notes, *held)
    for name in outputs:
        if np.ptp(recording[name]) == 0:
            raise InputError(
                f"{recording.name}: {name} is constant at {recording[name][0]:g} {recording.units[name]}; is the "
                "sensor connected?"
            )
    if all(np.std(recording[n]) < EXCITATION_RATIO * white_noise(recording[n]) for n in outputs):
        raise InputError(
            f"{recording.name}: no excitation: {', '.join(outputs)} are consistent with their noise; shake the "
            "handlebar, or let a disturbance move the vehicle"
        )
    intervals, excluded = undisturbed(recording, over, (over, *outputs, *inputs))
    factor = max(int(recording.rate / RATE), 1)
    coarse = tuple((-(-a // factor), b // factor) for a, b in intervals)
    needed = int((SETTLING_TIME + BLOCK) * recording.rate / factor)
    run = PredictedRun(
        recording,
        tuple(outputs),
        tuple(inputs),
        over,
        factor,
        tuple(s for s in coarse if s[1] - s[0] > needed),
        notes=notes,
    )
    blocks = len(run.blocks) if run.intervals else 0
    if blocks < FEWEST_BLOCKS:
        raise too_few_blocks(recording, blocks, excluded)
    return replace(run, notes=(*notes, note_on_blocks(recording, blocks, excluded)))
