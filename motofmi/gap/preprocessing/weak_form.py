r"""Recorded runs in which all states are measured: the equations of motion in weak form.

    - integral of phi_k' x dt = integral of phi_k f(x, u, p) dt,    phi_k = sqrt(2 / n) sin(pi k t / T)

on blocks of length T. Since phi_k vanishes at both ends, no measured rate is differentiated and no initial state is
needed. The method is the same for stable vehicles and for unstable ones under closed-loop control, and the excitation
is arbitrary. An unknown offset and drift of every equation in every block are projected out, and with them the offset
of an angle that is the integral of its rate. The noise is the disturbance, estimated as the residual of a flexible
model of the equations (see `weak_form_noise`).

Source: Shinbrot, Trans. ASME 79 (1957) 579-588; Preisig, Rippin, Comput. Chem. Eng. 17 (1993) 1-16.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.fft import dct, dst

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
from motofmi.recordings.resampling import uniform

BAND = (0.3, 5.0)  # Hz, in which the equations are compared


@dataclass(frozen=True, repr=False)
class WeakFormRun:
    """A run in blocks [first, first + length), and the whitened weak form of its measured rates.

    data (m,) are those of each equation in turn, with offset and drift projected out; `deviation` (m,) is one number
    per equation [rad/s2].
    """

    recording: Recording
    blocks: np.ndarray  # first samples
    length: int
    rates: tuple[str, ...]
    densities: tuple[Density, ...]
    held: bool = False  # whether inputs are held between samples (zero-order hold), as by a digital controller
    unit: str = "rad/s2"
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        blocks = f"{len(self.blocks)} blocks of {self.length} samples"
        return f"WeakFormRun({self.name!r}, {blocks}, rates {', '.join(self.rates)})"

    @property
    def name(self) -> str:
        """The name of the recording."""
        return self.recording.name

    @cached_property
    def places(self) -> np.ndarray:
        """The indices (blocks, length) of the samples of the blocks."""
        return self.blocks[:, None] + np.arange(self.length)

    @cached_property
    def frequency(self) -> np.ndarray:
        """The frequencies (k,) of the test functions [Hz]."""
        highest = int(2 * self.length * BAND[1] / self.recording.rate)
        frequency = np.arange(1, highest + 1) * self.recording.rate / (2 * self.length)
        return frequency[frequency >= BAND[0]]

    @cached_property
    def sizes(self) -> np.ndarray:
        """The root mean square of the disturbance of each equation (e,) [rad/s2]."""
        return np.array([np.sqrt(np.mean(density(self.frequency))) for density in self.densities])

    @cached_property
    def data(self) -> np.ndarray:
        """The whitened data (m,) [rad/s2]."""
        return self.whitened(self.measured)

    @cached_property
    def measured(self) -> np.ndarray:
        """The weak form (equations, blocks, k) of the derivatives of the measured rates [rad/s2]."""
        rates = np.stack([self.recording[n][self.places] for n in self.rates])
        return -2 * np.pi * self.frequency * dct(rates, norm="ortho")[..., self._orders]

    @cached_property
    def deviation(self) -> np.ndarray:
        """The standard deviation (m,) of the data, one number per equation [rad/s2]."""
        return np.repeat(self.sizes, len(self.blocks) * (len(self.frequency) - self.nuisance.shape[1]))

    @cached_property
    def _orders(self) -> np.ndarray:
        return np.round(self.frequency * 2 * self.length / self.recording.rate).astype(int)

    def inputs(self, name: str) -> np.ndarray:
        """An input (n,) as its mean over the sample interval around each sample."""
        u = self.recording.columns[name]
        return (u + np.concatenate([u[:1], u[:-1]])) / 2 if self.held else u

    def tested(self, signals: np.ndarray) -> np.ndarray:
        """The weak form (..., blocks, k) of signals (..., blocks, length)."""
        return dst(signals, norm="ortho")[..., self._orders - 1]

    def whitened(self, weak: np.ndarray) -> np.ndarray:
        """The data (..., m) [rad/s2] of a weak form (..., equations, blocks, k).

        They are whitened, without offset and drift, and multiplied by `sizes`.
        """
        parts = []
        for i, (whitener, size) in enumerate(zip(self.whiteners, self.sizes, strict=True)):
            part = weak[..., i, :, :] @ whitener * size
            parts.append(part.reshape(*part.shape[:-2], -1))
        return np.concatenate(parts, axis=-1)

    @cached_property
    def whiteners(self) -> list[np.ndarray]:
        """For each equation the matrix (k, k - 2) that divides by the noise and projects offset and drift out."""
        return [whitener(density(self.frequency), self.nuisance) for density in self.densities]

    @cached_property
    def nuisance(self) -> np.ndarray:
        """The weak form (k, 2) of an offset and a drift."""
        tau = np.linspace(-1, 1, self.length)
        return self.tested(np.stack([np.ones_like(tau), tau])[:, None, :])[:, 0].T


def prepare_weak_form(
    recording: Recording, over: str, rates: Sequence[str], sensors: Sequence[str], inputs: Sequence[str]
) -> WeakFormRun:
    """The run without the intervals in which the vehicle starts, stops or falls, and without outliers.

    over is the channel of the speed [m/s], rates are the states whose equations are compared, sensors are the recorded
    states and inputs the recorded inputs.
    The noise is not estimated yet. Raises InputError where fewer than two undisturbed blocks remain.
    """
    recording, notes = uniform(recording)
    recording, held = between_new_values(recording, sensors)
    intervals, excluded = undisturbed(recording, over, (*sensors, *inputs))
    length = int(BLOCK * recording.rate)
    blocks = np.array([b for first, last in intervals for b in range(first, last - length + 1, length)], int)
    if len(blocks) < FEWEST_BLOCKS:
        raise too_few_blocks(recording, len(blocks), excluded)
    note = note_on_blocks(recording, len(blocks), excluded)
    flat = tuple(Density(np.array([0.0, recording.rate / 2]), np.ones(2)) for _ in rates)
    return WeakFormRun(recording, blocks, length, tuple(rates), flat, notes=(*notes, *held, note))


def whitener(density: np.ndarray, nuisance: np.ndarray) -> np.ndarray:
    """The matrix (k, k - j) that whitens by a density (k,) and projects nuisance signals (k, j) out."""
    deviation = np.sqrt(density)[:, None]
    return np.linalg.qr(nuisance / deviation, mode="complete")[0][:, nuisance.shape[1] :] / deviation


def with_noise(run: WeakFormRun, densities: Sequence[Density]) -> WeakFormRun:
    """The run with the disturbance densities of its equations [(rad/s2)^2 per sample]."""
    return replace(run, densities=tuple(densities))
