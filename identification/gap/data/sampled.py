"""A run of any component, made ready: told what was recorded, compared on the cosines of its blocks.

Nothing is asked of the excitation. The run is cut into segments of a few periods whose initial states are unknown: over
long ones small errors add up to lost phase, a fit then has many minima, and what is unstable cannot be simulated at all.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d

from fmus.errors import InputError
from identification.gap.data.blocks import Blocks, blocks_of
from identification.gap.data.flexible import Density
from identification.gap.data.hum import without_hum
from identification.gap.data.stretches import unbroken
from identification.gap.data.told import (
    CLEAR,
    KINDS,
    NOISELESS,
    Told,
    highest_frequency,
    input_function,
    motion_functions,
)
from identification.gap.stands.component_test import ComponentTest
from identification.recordings import Recording
from identification.sampling import LEAST_SIGNAL, slower, uniform, white_noise

FEWEST = 200  # samples
POINTS = 8  # of the simulation per cycle of the highest frequency
MOST_POINTS = 40_000  # of the simulation of one run
PERIODS = 6.0  # of the middle frequency in a segment
IMPOSED_PERIODS = 60.0  # where a state is imposed: what else moves forgets where it began
SHORTEST_SEGMENT = 100  # samples
ACCURACY = 3e-4  # of a signal's rms, which no model of a real component is better than
FASTER, MOST_SAMPLES = 20, 6000  # a recording so many times faster than what is in it is reduced, where it has more samples
NEIGHBOURS = 9  # cosines over which a variance is averaged
EDGE = 0.02  # share of an imposed motion's record at each end: its acceleration is not known there


@dataclass
class Sampled:
    """A recording on the cosines of its blocks: data (m,) and their deviation (m,)."""

    recording: Recording
    test: ComponentTest
    measured: np.ndarray  # (n, outputs)
    told: Told
    stretches: list[tuple[int, int]]  # without gaps
    segments: list[tuple[int, int]]
    finer: int  # steps of the simulation per sample
    reduction: Blocks
    densities: list[Density]
    noise_source: str
    data: np.ndarray
    deviation: np.ndarray
    notes: tuple[str, ...] = ()
    noise_rests_on_a_model: bool = False
    kind: str = KINDS[0]  # how the inputs are joined between their samples
    unsure: np.ndarray | None = None  # (m,) variance that comes with what the inputs do between their samples
    guess: dict[Any, dict[str, Any]] = field(default_factory=dict)  # where simulations of it begin, by segment, and by model and segment

    @property
    def name(self) -> str:
        return self.recording.name

    @property
    def unit(self) -> str:
        """The unit of the motion by whose size parts of a run are told apart."""
        return self.recording.units[self.test.imposed or self.test.outputs[0]]

    @property
    def duration(self) -> float:
        """From time zero to the end of the run [s]."""
        return float(self.recording.time[-1] + 1 / self.recording.rate)

    def moved(self, time: np.ndarray) -> tuple[np.ndarray]:
        """The motion (n,) at times (n,)."""
        return (np.interp(time, self.recording.time, self.recording[self.test.imposed or self.test.outputs[0]]),)

    def with_densities(self, densities: list[Density], source: str) -> "Sampled":
        """The run with another noise."""
        least = [(ACCURACY * np.std(y)) ** 2 for y in self.measured.T]
        densities = [d.at_least(x) for d, x in zip(densities, least, strict=True)]
        deviation = self.reduction.deviations(densities)
        if self.unsure is not None:
            deviation = np.sqrt(deviation**2 + self.unsure)
        return replace(self, densities=densities, noise_source=source, deviation=deviation)

    def with_unsure(self, difference: np.ndarray) -> "Sampled":
        """The run with the change (m,) of what a model answers to its inputs joined in another way, as a further variance."""
        sizes = [kept for _, _, kept in self.reduction.spans for _ in range(self.reduction.outputs)]
        parts = np.split(difference**2, np.cumsum(sizes)[:-1])
        smooth = np.concatenate([uniform_filter1d(part, min(NEIGHBOURS, len(part)), mode="nearest") for part in parts])
        return replace(self, unsure=smooth).with_densities(self.densities, self.noise_source)

    def with_told(self, kind: str) -> "Sampled":
        """The run with its inputs joined in another way between their samples."""
        return replace(self, told=_told(self.recording, self.test, kind), kind=kind, guess={})

    @cached_property
    def noiseless(self) -> "Sampled":
        """The run told the imposed motion without its noise; itself where nothing is imposed."""
        return self.with_told(NOISELESS) if self.test.imposed else self

    def remembering(self, guess: Mapping[Any, Any]) -> "Sampled":
        """The run with another memory of what it was simulated from."""
        return replace(self, guess={key: dict(known) for key, known in guess.items()})

    def scaled(self, factor: float) -> "Sampled":
        """The run as it would be with its excitation times a factor, if the component were linear."""
        measured = factor * self.measured
        return replace(self, told=self.told.scaled(factor), measured=measured, data=self.reduction.reduce(measured), guess={})

    def cut(self, length: int) -> "Sampled":
        """The run in segments of so many samples, each with its own initial states."""
        segments: list[tuple[int, int]] = []
        for first, last in self.stretches:
            edges = np.linspace(first, last, max((last - first) // max(length, 8), 1) + 1).astype(int)
            segments += [(int(a), int(b)) for a, b in pairwise(edges)]
        reduction = blocks_of(segments, len(self.test.outputs), self.recording.rate, self.reduction_band)
        return replace(self, segments=segments, reduction=reduction, data=reduction.reduce(self.measured), guess={},
                       unsure=None, deviation=reduction.deviations(self.densities))  # fmt: skip

    @cached_property
    def middle_frequency(self) -> float:
        """The power-weighted mean frequency [Hz] of the first output's changes, as far as they stand clear of its noise."""
        change = np.diff(self.measured[:, 0])
        window = np.hanning(len(change))
        power, cycles = np.abs(np.fft.rfft(change * window)) ** 2, np.fft.rfftfreq(len(change))
        noise = white_noise(self.measured[:, 0]) ** 2 * np.sum(window**2) * (2 - 2 * np.cos(2 * np.pi * cycles))
        clear = power > CLEAR * noise
        return max(float(np.sum(power[clear] * cycles[clear]) / max(np.sum(power[clear]), 1e-300)) * self.recording.rate, 2 / self.duration)

    @property
    def reduction_band(self) -> float:
        """The frequency up to which the run is compared [Hz]."""
        return max(c.frequency for c in self.reduction.columns)


def prepare_sampled(recording: Recording, test: ComponentTest) -> Sampled:
    """The run, its noise a first guess. Raises InputError for a run that is too short, still or without noise."""
    recording, bridged = uniform(recording)
    recording, hum = without_hum(recording.from_zero(), test.inputs, test.outputs)
    recording, reduced = _reduced(recording, test)
    notes = (*bridged, *hum, *reduced)
    if len(recording.time) < FEWEST:
        raise InputError(f"{recording.name}: {len(recording.time)} samples are too few to tell noise from a gap; expected at least {FEWEST}")
    for name in test.outputs:
        y, unit, noise = recording[name], recording.units[name], white_noise(recording[name])
        if np.ptp(y) == 0:
            raise InputError(f"{recording.name}: {name} is constant at {y[0]:g} {unit}; is the sensor connected?")
        if np.std(y) < LEAST_SIGNAL * noise:
            raise InputError(f"{recording.name}: no excitation: {name} varies by {np.std(y):.2g} {unit} (rms), its noise is {noise:.2g}")
    return sampled(recording, test, notes)


def sampled(recording: Recording, test: ComponentTest, notes: tuple[str, ...] = ()) -> Sampled:
    """The run of a recording on a regular grid, whatever it holds; its noise a first guess."""
    time, rate = recording.time, recording.rate
    measured = np.column_stack([recording[name] for name in test.outputs])
    deviations = [white_noise(y) for y in measured.T]
    highest = max(highest_frequency(y, rate) for y in measured.T)
    band = min(1.3 * highest + 4 * rate / len(time), rate / 2)
    edge = int(EDGE * len(time)) if test.imposed else 0
    stretches = [s for s in unbroken(~recording.broken, edge) if s[1] - s[0] >= SHORTEST_SEGMENT // 2]
    if not stretches:
        raise InputError(f"{recording.name}: no {SHORTEST_SEGMENT // 2} samples in a row without a gap; cut the recording into parts without gaps")
    reduction = blocks_of(stretches, len(test.outputs), rate, band)
    finer = int(np.clip(np.ceil(POINTS * highest / rate), 1, max(MOST_POINTS // len(time), 1)))
    densities = [Density(np.array([0.0, rate / 2]), np.full(2, max(s, ACCURACY * np.std(y)) ** 2)) for s, y in zip(deviations, measured.T, strict=True)]
    whole = Sampled(recording, test, measured, _told(recording, test, KINDS[0]), stretches, stretches, finer, reduction, densities, "",
                    reduction.reduce(measured), reduction.deviations(densities), notes)  # fmt: skip
    periods = IMPOSED_PERIODS if test.imposed else PERIODS
    return whole.cut(max(int(periods * rate / whole.middle_frequency), SHORTEST_SEGMENT))


def _reduced(recording: Recording, test: ComponentTest) -> tuple[Recording, tuple[str, ...]]:
    """The recording at a lower rate, where it is much faster than what moves in it."""
    wanted = [*test.outputs, *test.inputs]
    highest = max(highest_frequency(recording[n], recording.rate) for n in wanted if np.ptp(recording[n]) > 0)
    factor = int(recording.rate / (FASTER * highest))
    if factor < 2 or len(recording.time) < MOST_SAMPLES:
        return recording, ()
    factor = min(factor, len(recording.time) // (MOST_SAMPLES // 2))
    note = f"{recording.name}: reduced to {recording.rate / factor:.4g} Hz; nothing in it is faster than {highest:.3g} Hz"
    return slower(recording, factor), (note,)


def _told(recording: Recording, test: ComponentTest, kind: str) -> Told:
    time = recording.time
    functions: dict[str, Any] = {n: input_function(time, recording[n], kind) for n in test.inputs if n != test.imposed}
    if test.imposed:
        seen = test.with_effects(())
        motion = motion_functions(time, recording[test.imposed], seen.rate, kind)  # type: ignore[attr-defined]
        functions |= {name or test.imposed: function for name, function in motion.items()}
    return Told(functions, (float(time[0]), float(time[-1])))


def excited(runs: Sequence[Sampled]) -> bool:
    """Whether any recorded input drives the component; otherwise only ratios of its parameters show."""
    return any(np.ptp(run.recording[n]) > 0 for run in runs for n in run.test.inputs)
