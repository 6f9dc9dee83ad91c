r"""Recorded runs whose states are all measured: the equations of motion in weak form, without initial states or derivatives.

    - integral of phi_k' x dt = integral of phi_k f(x, u, p) dt,    phi_k = sqrt(2 / n) sin(pi k t / T)

on blocks of length T. As phi_k vanishes at both ends, the derivative of a measured rate is never formed, an unstable
vehicle under closed-loop control is no different from a stable one, and nothing is asked of the excitation. An unknown
offset and drift of every equation in every block are projected out; with them goes the offset of an angle that is the
integral of its rate. What not even a rich model takes out of the equations (see `weak_noise`) is the disturbance: the noise.

Source: Shinbrot, Trans. ASME 79 (1957) 579-588; Preisig, Rippin, Comput. Chem. Eng. 17 (1993) 1-16.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.fft import dct, dst

from fmus.errors import InputError
from identification.gap.data.flexible import Density
from identification.gap.data.stretches import MARGIN, undisturbed
from identification.recordings import Recording
from identification.sampling import uniform

BLOCK = 10.0  # s
BAND = (0.3, 5.0)  # Hz in which the equations are compared
FEWEST = 2  # blocks of a run


@dataclass(frozen=True)
class WeakRun:
    """A run in blocks [first, first + length), and the weak form of its measured rates, whitened.

    data (m,) are those of each equation in turn, projected on what no offset or drift can make, in units of `deviation`
    (m,), which is one number per equation [rad/s2].
    """

    recording: Recording
    blocks: np.ndarray  # first samples
    length: int
    rates: tuple[str, ...]
    densities: tuple[Density, ...]
    held: bool = False  # whether inputs are held from one sample to the next, as by a digital controller
    unit: str = "rad/s2"
    notes: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        return self.recording.name

    @cached_property
    def places(self) -> np.ndarray:
        """The samples (blocks, length) of the blocks."""
        return self.blocks[:, None] + np.arange(self.length)

    @cached_property
    def frequency(self) -> np.ndarray:
        """The frequencies (k,) of the test functions [Hz]."""
        k = np.arange(1, int(2 * self.length * BAND[1] / self.recording.rate) + 1) * self.recording.rate / (2 * self.length)
        return k[k >= BAND[0]]

    @cached_property
    def sizes(self) -> np.ndarray:
        """The typical deviation of each equation (e,) [rad/s2]."""
        return np.array([np.sqrt(np.mean(density(self.frequency))) for density in self.densities])

    @cached_property
    def data(self) -> np.ndarray:
        return self.whitened(self.measured)

    @cached_property
    def measured(self) -> np.ndarray:
        """The weak form (equations, blocks, k) of the derivatives of the measured rates [rad/s2]."""
        rates = np.stack([self.recording[n][self.places] for n in self.rates])
        return -2 * np.pi * self.frequency * dct(rates, norm="ortho")[..., self._orders]

    @cached_property
    def deviation(self) -> np.ndarray:
        return np.repeat(self.sizes, len(self.blocks) * (len(self.frequency) - self.nuisance.shape[1]))

    @cached_property
    def _orders(self) -> np.ndarray:
        return np.round(self.frequency * 2 * self.length / self.recording.rate).astype(int)

    def told(self, name: str) -> np.ndarray:
        """An input (n,) in the mean over the interval around each sample."""
        u = self.recording.columns[name]
        return (u + np.concatenate([u[:1], u[:-1]])) / 2 if self.held else u

    def tested(self, signals: np.ndarray) -> np.ndarray:
        """The weak form (..., blocks, k) of signals (..., blocks, length)."""
        return dst(signals, norm="ortho")[..., self._orders - 1]

    def whitened(self, weak: np.ndarray) -> np.ndarray:
        """From (..., equations, blocks, k) the numbers (..., m): over the noise, without offset and drift, times the sizes."""
        parts = []
        for i, (whitener, size) in enumerate(zip(self.whiteners, self.sizes, strict=True)):
            part = weak[..., i, :, :] @ whitener * size
            parts.append(part.reshape(*part.shape[:-2], -1))
        return np.concatenate(parts, axis=-1)

    @cached_property
    def whiteners(self) -> list[np.ndarray]:
        """For each equation the matrix (k, k - 2) that divides by the noise and leaves offset and drift out."""
        return [whitener(density(self.frequency), self.nuisance) for density in self.densities]

    @cached_property
    def nuisance(self) -> np.ndarray:
        """The weak form (k, 2) of an offset and a drift."""
        tau = np.linspace(-1, 1, self.length)
        return self.tested(np.stack([np.ones_like(tau), tau])[:, None, :])[:, 0].T


def prepare_weak(recording: Recording, over: str, rates: Sequence[str], needed: Sequence[str]) -> WeakRun:
    """The run with all its states, cut where the vehicle starts, stops or falls, and at wild samples; its noise is not known yet.

    rates are the states whose equations are compared, needed all channels. Raises InputError where too little is left.
    """
    recording, notes = uniform(recording)
    stretches, cut = undisturbed(recording, over, needed)
    length = int(BLOCK * recording.rate)
    blocks = np.array([b for first, last in stretches for b in range(first, last - length + 1, length)], int)
    if len(blocks) < FEWEST:
        raise InputError(f"{recording.name}: {len(blocks)} undisturbed stretches of {BLOCK:g} s; expected at least {FEWEST}")
    said = (f"{recording.name}: {len(blocks) * BLOCK:g} of {len(recording.time) / recording.rate:.0f} s are compared: {cut} are cut with {MARGIN:g} s "
            "at both sides, the rest in whole blocks",)  # fmt: skip
    flat = tuple(Density(np.array([0.0, recording.rate / 2]), np.ones(2)) for _ in rates)
    return WeakRun(recording, blocks, length, tuple(rates), flat, notes=(*notes, *said))


def whitener(density: np.ndarray, nuisance: np.ndarray) -> np.ndarray:
    """From a density (k,) and what is not known (k, j): the matrix (k, k - j) that whitens and projects."""
    deviation = np.sqrt(density)[:, None]
    return np.linalg.qr(nuisance / deviation, mode="complete")[0][:, nuisance.shape[1] :] / deviation


def with_noise(run: WeakRun, densities: Sequence[Density]) -> WeakRun:
    """The run with the densities of its equations' disturbances."""
    return replace(run, densities=tuple(densities))
