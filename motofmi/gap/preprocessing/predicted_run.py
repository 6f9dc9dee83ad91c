r"""Recorded runs of which not all states are measured, made ready to be predicted from sample to sample.

Disturbances that nobody records drive the vehicle, and under closed-loop control the inputs with it. What remains
comparable is the error of the prediction from one sample to the next: if the model is right it depends on nothing that
was known before, under feedback too. Errors are compared on the cosines of blocks, at all frequencies above those of offsets and drift.

Source: Ljung, System Identification, 2nd ed. (1999), ch. 7 and 13.4.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.fft import dct

from fmus.errors import InputError
from identification.gap.data.flexible import Density
from identification.gap.data.stretches import MARGIN, undisturbed
from identification.recordings import Recording
from identification.sampling import uniform, white_noise

RATE = 80.0  # Hz: what is faster is averaged down to it, or a little above
BLOCK = 10.0  # s
MOVES = 2.0  # times the noise of a sensor that lies still: its deviation where something moves
BURN = 3.0  # s at the start of a stretch, in which the prediction forgets where it began
FEWEST = 2  # blocks of a run
LOWEST = 0.3  # Hz that are compared; up to half of the rate, else a predictor shifts its errors to where nobody compares them
SPEEDS = 0.04  # between speeds for which matrices are computed, relative
STEADY = 0.005  # by how much the speed may change, relative, and be one


@dataclass(frozen=True)
class PredictedRun:
    """A run: outputs that are compared, inputs that are told, `factor` samples averaged to one, in stretches [first, last).

    noise (k,) says how large the disturbances and the sensors' noises are (see `models.disturbances`). mixing (ny, ny) and
    densities make of prediction errors independent numbers of deviation 1.
    """

    recording: Recording
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    over: str
    factor: int
    stretches: tuple[tuple[int, int], ...]
    noise: np.ndarray | None = None
    mixing: np.ndarray | None = None
    densities: tuple[Density, ...] = ()
    held: bool = False  # whether inputs are held from one sample to the next, as by a digital controller
    unit: str = "1"
    notes: tuple[str, ...] = ()
    motion: Mapping[str, np.ndarray] = field(default_factory=dict, compare=False)  # the vehicle's states (n,) as predicted from what was known before

    @property
    def name(self) -> str:
        return self.recording.name

    @property
    def step(self) -> float:
        """Between two averaged samples [s]."""
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
        """Whether inputs are told as they are held; where samples are averaged, the interval over which they are is short."""
        return self.held and self.factor == 1

    def joined(self, values: np.ndarray) -> np.ndarray:
        """An input (N,) for a prediction that joins its averaged values (n,) by lines.

        Lines between samples of a smooth signal are too small by its curvature, h^2 / 12 of which is therefore taken off.
        """
        if self.exactly_held:
            return values
        if self.held:
            values = (values + np.concatenate([values[:1], values[:-1]])) / 2
        u = self.averaged(values)
        return u - np.convolve(np.pad(u, 1, mode="edge"), [1, -2, 1], "valid") / 12

    @cached_property
    def speeds(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Speeds (g,) for which matrices are needed, and for every sample (n,) its place among them and the share of the next."""
        speed = self.averaged(self.recording[self.over])
        width = max(int(1 / (self.step * 2)), 1)
        smooth = np.convolve(np.pad(speed, width, mode="edge"), np.ones(2 * width + 1) / (2 * width + 1), "valid")
        within = np.concatenate([smooth[a:b] for a, b in self.stretches])
        low, high = np.quantile(within, [0.01, 0.99])
        mean = float(within.mean())
        if high - low < STEADY * mean:
            return np.array([mean]), np.zeros(len(speed), np.int64), np.zeros(len(speed))
        grid = np.linspace(low, high, int(np.ceil((high - low) / (SPEEDS * mean))) + 1)
        at = np.clip((smooth - grid[0]) / (grid[1] - grid[0]), 0, len(grid) - 1 - 1e-9)
        return grid, at.astype(np.int64), at - np.floor(at)

    @cached_property
    def blocks(self) -> np.ndarray:
        """The first samples of the blocks."""
        burn = int(BURN / self.step)
        return np.array([b for first, last in self.stretches for b in range(first + burn, last - self.length + 1, self.length)], int)

    @cached_property
    def compared(self) -> np.ndarray:
        """The samples of all blocks."""
        return (self.blocks[:, None] + np.arange(self.length)).ravel()

    @property
    def length(self) -> int:
        """Samples of a block."""
        return int(BLOCK / self.step)

    @cached_property
    def frequency(self) -> np.ndarray:
        """The frequencies (k,) that are compared [Hz]."""
        every = np.arange(self.length) / (2 * self.length * self.step)
        return every[every >= LOWEST]

    def cosines(self, errors: np.ndarray) -> np.ndarray:
        """Of errors (n, ny, ...) over time the cosines (ny, blocks, k, ...), the channels mixed so that they are independent."""
        assert self.mixing is not None
        taken = errors[self.blocks[:, None] + np.arange(self.length)]
        spectrum = dct(taken, axis=1, norm="ortho")[:, np.round(self.frequency * 2 * self.length * self.step).astype(int)]
        return np.einsum("ij,bkj...->ibk...", self.mixing, spectrum)

    def whitened(self, errors: np.ndarray) -> np.ndarray:
        """Of errors (n, ny, ...) over time the numbers (m, ...) of deviation 1."""
        parts = self.cosines(errors)
        deviation = np.sqrt(np.stack([d(self.frequency) for d in self.densities]))[:, None, :]
        parts = parts / deviation.reshape(*deviation.shape, *[1] * (parts.ndim - 3))
        return parts.reshape(-1, *parts.shape[3:])

    @cached_property
    def data(self) -> np.ndarray:
        """Zeros (m,): what a perfect prediction leaves."""
        return np.zeros(len(self.outputs) * len(self.blocks) * len(self.frequency))

    @cached_property
    def deviation(self) -> np.ndarray:
        return np.ones_like(self.data)

    def with_noise(self, noise: np.ndarray, motion: Mapping[str, np.ndarray]) -> "PredictedRun":
        """The run with disturbances and sensors' noises as large as that, and the motion as it is then predicted."""
        return replace(self, noise=noise, motion=motion)

    def with_floor(self, mixing: np.ndarray, densities: Sequence[Density]) -> "PredictedRun":
        """The run with what no prediction can be better than."""
        return replace(self, mixing=mixing, densities=tuple(densities))


def prepare_predicted(recording: Recording, over: str, outputs: Sequence[str], inputs: Sequence[str]) -> PredictedRun:
    """The run, cut where the vehicle starts, stops or falls, and at wild samples; disturbances and noise are not known yet.

    Raises InputError where too little is left, or an output stands still.
    """
    recording, notes = uniform(recording)
    for name in outputs:
        if np.ptp(recording[name]) == 0:
            raise InputError(f"{recording.name}: {name} is constant at {recording[name][0]:g} {recording.units[name]}; is the sensor connected?")
    if all(np.std(recording[n]) < MOVES * white_noise(recording[n]) for n in outputs):
        raise InputError(f"{recording.name}: no excitation: {', '.join(outputs)} hold nothing but noise; shake the handlebar, or let a disturbance move the vehicle")
    stretches, said = undisturbed(recording, over, (over, *outputs, *inputs))
    factor = max(int(recording.rate / RATE), 1)
    coarse = tuple((-(-a // factor), b // factor) for a, b in stretches)
    needed = int((BURN + BLOCK) * recording.rate / factor)
    run = PredictedRun(recording, tuple(outputs), tuple(inputs), over, factor, tuple(s for s in coarse if s[1] - s[0] > needed), notes=notes)
    if not run.stretches or len(run.blocks) < FEWEST:
        raise InputError(f"{recording.name}: {len(run.blocks) if run.stretches else 0} undisturbed stretches of {BLOCK:g} s; expected at least {FEWEST}")
    used = len(run.blocks) * BLOCK
    note = f"{recording.name}: {used:g} of {len(recording.time) / recording.rate:.0f} s are compared: {said} are cut with {MARGIN:g} s at both sides, the rest in whole blocks"
    return replace(run, notes=(*notes, note))
