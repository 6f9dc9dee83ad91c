"""A run of any component, prepared for comparison over time, as cosine coefficients of blocks.

The excitation is arbitrary. The run is cut into segments of a few periods with unknown initial states. Over a long
segment small errors of the model accumulate to a phase error, so that a fit has many minima; an unstable component
cannot be simulated over it at all.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d

from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.blocks import Blocks, blocks_of
from motofmi.gap.preprocessing.flexible_noise_model import Density
from motofmi.gap.preprocessing.free_decay import highest_of_motion, is_free, mean_frequency
from motofmi.gap.preprocessing.input_interpolation import (
    HELD,
    INTERPOLATIONS,
    NOISELESS,
    InterpolatedInputs,
    input_function,
    motion_functions,
)
from motofmi.gap.preprocessing.one_way import direction_of, is_one_way
from motofmi.gap.preprocessing.segments import LEAST_LENGTH, segments_of
from motofmi.recordings.recording import Recording

STEPS_PER_CYCLE = 8  # simulation steps per cycle of the highest frequency
MOST_STEPS = 40_000  # simulation steps of one run
SHORTEST_SEGMENT = 100  # samples
ACCURACY = 3e-4  # least noise over a signal's rms [1]: no model of a real component is more accurate
NEIGHBOURS = 9  # coefficients over which a variance is averaged


@dataclass(repr=False)
class SampledRun:
    """A recording as cosine coefficients of its blocks: data (m,) and their standard deviation (m,).

    The coefficients have the units of the outputs. Intervals and segments are [first, last) in samples.
    """

    recording: Recording
    experiment: InputOutputExperiment
    measured: np.ndarray  # (n, outputs)
    inputs: InterpolatedInputs
    intervals: list[tuple[int, int]]  # between gaps
    segments: list[tuple[int, int]]  # with an own initial state each
    steps_per_sample: int  # simulation steps per sample
    reduction: Blocks
    densities: list[Density]
    noise_source: str
    data: np.ndarray
    deviation: np.ndarray
    notes: tuple[str, ...] = ()
    noise_from_model: bool = False
    kind: str = INTERPOLATIONS[0]  # interpolation of the inputs
    one_way_rates: frozenset[str] = frozenset()  # recorded rates of elements that have one sign
    without_offsets: bool = False  # the offsets of the outputs' sensors are taken as zero
    input_variance: np.ndarray | None = None  # (m,) variance due to the inputs between their samples
    # (n,) the longest segment [samples] at each sample over which an unstable free motion does not grow too far
    stable_length: np.ndarray | None = None
    longest_of_integrator: float = 0.0  # s, the longest segment where the component is a double integrator, else 0
    # the inputs by their interpolation, each computed once for all copies of the run
    interpolated: dict[str, InterpolatedInputs] = field(default_factory=dict)
    # initial guesses of simulations, by segment, and by model and segment
    guess: dict[Any, dict[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.interpolated.setdefault(self.kind, self.inputs)

    def __repr__(self) -> str:
        inputs, outputs = (", ".join(names) for names in (self.experiment.inputs, self.experiment.outputs))
        samples = f"{len(self.recording.time)} samples"
        return f"SampledRun({self.name!r}, {samples}, inputs {inputs or 'none'}, outputs {outputs})"

    @property
    def name(self) -> str:
        """The name of the recording."""
        return self.recording.name

    @property
    def unit(self) -> str:
        """The unit of the motion by whose amplitude parts of a run are distinguished."""
        return self.recording.units[self.experiment.imposed or self.experiment.outputs[0]]

    @property
    def duration(self) -> float:
        """The time from zero to the end of the run [s]."""
        return float(self.recording.time[-1] + 1 / self.recording.rate)

    def motion_at(self, time: np.ndarray) -> tuple[np.ndarray]:
        """The imposed motion, or the first output, (n,) at times (n,) [s]."""
        name = self.experiment.imposed or self.experiment.outputs[0]
        return (np.interp(time, self.recording.time, self.recording[name]),)

    def with_densities(self, densities: list[Density], source: str) -> "SampledRun":
        """The run with a noise density for each output, and the name of their source."""
        least = ACCURACY**2 * self.motion_variance
        densities = [d.at_least(x) for d, x in zip(densities, least, strict=True)]
        deviation = self.reduction.deviations(densities)
        if self.input_variance is not None:
            deviation = np.sqrt(deviation**2 + self.input_variance)
        return replace(self, densities=densities, noise_source=source, deviation=deviation)

    def with_scaled_noise(self, factor: float) -> "SampledRun":
        """The run with the variance of its noise multiplied by a factor."""
        densities = [replace(d, density=factor * d.density) for d in self.densities]
        variance = None if self.input_variance is None else factor * self.input_variance
        return replace(self, densities=densities, deviation=np.sqrt(factor) * self.deviation, input_variance=variance)

    def with_input_variance(self, difference: np.ndarray) -> "SampledRun":
        """The run with an additional variance due to the interpolation of its inputs.

        difference (m,) is the change of a model's output, in the units of the data, between two interpolations.
        """
        sizes = [kept for _, _, kept in self.reduction.spans for _ in range(self.reduction.outputs)]
        parts = np.split(difference**2, np.cumsum(sizes)[:-1])
        smooth = np.concatenate([uniform_filter1d(part, min(NEIGHBOURS, len(part)), mode="nearest") for part in parts])
        return replace(self, input_variance=smooth).with_densities(self.densities, self.noise_source)

    def with_interpolation(self, kind: str) -> "SampledRun":
        """The run with another interpolation of its inputs, of `input_interpolation.INTERPOLATIONS`."""
        if kind not in self.interpolated:
            self.interpolated[kind] = interpolated_inputs(self.recording, self.experiment, kind)
        # Held inputs have their corners in the middle between two samples, where a step has to end.
        odd = self.steps_per_sample % 2 if kind == HELD else 0
        return replace(
            self, inputs=self.interpolated[kind], kind=kind, steps_per_sample=self.steps_per_sample + odd, guess={}
        )

    @cached_property
    def noiseless(self) -> "SampledRun":
        """The run with an imposed motion from which noise is removed; itself where no motion is imposed."""
        return self.with_interpolation(NOISELESS) if self.experiment.imposed else self

    def with_initial_guesses(self, guess: Mapping[Any, Any]) -> "SampledRun":
        """The run with other initial guesses of its simulations."""
        return replace(self, guess={key: dict(known) for key, known in guess.items()})

    def scaled(self, factor: float) -> "SampledRun":
        """The run with its inputs and outputs multiplied by a factor, as for a linear component."""
        measured = factor * self.measured
        columns = {name: factor * column for name, column in self.recording.columns.items()}
        return replace(
            self,
            recording=replace(self.recording, columns=columns),
            inputs=self.inputs.scaled(factor),
            interpolated={},
            measured=measured,
            data=self.reduction.reduce(measured),
            guess={},
        )

    def cut(self, length: int) -> "SampledRun":
        """The run in segments of `length` samples, shorter where `stable_length` is, each with its own initial
        states; where its intervals begin at rest, these are the segments."""
        lengths = np.full(len(self.measured), max(length, LEAST_LENGTH))
        if self.stable_length is not None:
            lengths = np.minimum(lengths, self.stable_length)
        if self.experiment.from_rest:
            lengths = np.full(len(self.measured), len(self.measured))
        segments = [s for interval in self.intervals for s in segments_of(*interval, lengths)]
        reduction = blocks_of(
            segments, len(self.experiment.outputs), self.recording.rate, self.reduction_band, self.reduction.compared
        )
        return replace(
            self,
            segments=segments,
            reduction=reduction,
            data=reduction.reduce(self.measured),
            deviation=reduction.deviations(self.densities),
            guess={},
            input_variance=None,
        )

    def with_band_of_segments(self) -> "SampledRun":
        """The run compared up to the highest frequency of the motion within its segments, and simulated in as many
        steps as that needs.

        An angle that goes round grows with the recording. Its power at the lowest frequencies is then so large that
        the motion within a segment is a negligible share of it.
        """
        length = int(np.median([last - first for first, last in self.segments]))
        moving = self.measured - uniform_filter1d(self.measured, length, axis=0, mode="nearest")
        rate = self.recording.rate
        free = is_free(self.recording, self.experiment.inputs)
        highest = max(highest_of_motion(y, rate, free) for y in moving.T)
        band = max(compared_band(highest, rate, len(moving)), self.reduction_band)
        reduction = blocks_of(self.segments, self.reduction.outputs, rate, band, self.reduction.compared)
        return replace(
            self,
            reduction=reduction,
            data=reduction.reduce(self.measured),
            steps_per_sample=simulation_steps(highest, rate, len(moving)),
            guess={},
            input_variance=None,
        ).with_densities(self.densities, self.noise_source)

    @cached_property
    def powers_of_segments(self) -> tuple[list[float], list[float]]:
        """The mean squares of the data and of their standard deviation, of every segment."""
        rows = self.reduction.rows
        data, noise = ([float(np.mean(y[of] ** 2)) for of in rows] for y in (self.data, self.deviation))
        return data, noise

    @cached_property
    def middle_frequency(self) -> float:
        """The power-weighted mean frequency [Hz] of the first output, where it exceeds its noise."""
        return max(mean_frequency(self.measured[:, 0], self.recording.rate), 2 / self.duration)

    @property
    def with_offset(self) -> np.ndarray:
        """Whether the offset of each output's sensor is unknown (outputs,); see `one_way` for the others."""
        if self.without_offsets:
            return np.zeros(len(self.experiment.outputs), bool)
        elements = self.experiment.component.elements.values()
        alone = {
            e.rate for e in elements if e.rate in self.one_way_rates and e.deflection not in self.recording.columns
        }
        return np.array([name not in alone for name in self.experiment.outputs])

    @property
    def direction(self) -> float:
        """The sign of the rate of an element that moves one way, recorded or that of a recorded deflection; else 0."""
        for name in sorted(self.one_way_rates):
            if is_one_way(self.recording[name]):
                return float(np.sign(np.sum(self.recording[name])))
        for name in sorted({e.deflection for e in self.experiment.component.elements.values()}):
            if name in self.recording.columns:
                ways = {direction_of(self.recording[name][first:last]) for first, last in self.intervals}
                if len(ways) == 1 and ways != {0.0}:
                    return ways.pop()
        return 0.0

    @property
    def directions(self) -> set[float]:
        """The direction of the run; where the motion is imposed those of its segments, since each has an offset."""
        if not self.experiment.imposed:
            return {self.direction}
        motion = self.recording[self.experiment.imposed]
        return {direction_of(motion[first:last]) for first, last in self.segments}

    @property
    def motion_variance(self) -> np.ndarray:
        """The variance (outputs,) of the outputs about their means in each segment.

        The angle of a joint that turns on and on grows with the recording, and its misfit from segment to segment does
        not: it is compared with the motion in a segment.
        """
        squares = sum((last - first) * self.measured[first:last].var(axis=0) for first, last in self.segments)
        return squares / sum(last - first for first, last in self.segments)

    @property
    def reduction_band(self) -> float:
        """The frequency up to which the run is compared [Hz]."""
        return max(c.frequency for c in self.reduction.columns)


def compared_band(highest: float, rate: float, samples: int) -> float:
    """The frequency up to which a signal with a highest frequency is compared; all in Hz."""
    return min(1.3 * highest + 4 * rate / samples, rate / 2)


def simulation_steps(highest: float, rate: float, samples: int) -> int:
    """The simulation steps for a highest frequency and a sampling rate [Hz]."""
    return int(np.clip(np.ceil(STEPS_PER_CYCLE * highest / rate), 1, max(MOST_STEPS // samples, 1)))


def interpolated_inputs(recording: Recording, experiment: InputOutputExperiment, kind: str) -> InterpolatedInputs:
    """The recorded inputs, and an imposed motion with its derivatives, as functions of time."""
    time = recording.time
    functions: dict[str, Any] = {
        n: input_function(time, recording[n], kind) for n in experiment.inputs if n != experiment.imposed
    }
    if experiment.imposed:
        rate: str = experiment.with_effects(()).rate  # type: ignore[attr-defined]
        motion = motion_functions(time, recording[experiment.imposed], rate, kind)
        functions |= {name or experiment.imposed: function for name, function in motion.items()}
    return InterpolatedInputs(functions, (float(time[0]), float(time[-1])))


def move_both_ways(runs: Sequence[SampledRun]) -> bool:
    """Whether every run, or every segment of an imposed motion, moves one way, and not all move the same way."""
    return set().union(*(run.directions for run in runs)) == {-1.0, 1.0}


def excited(runs: Sequence[SampledRun]) -> bool:
    """Whether any recorded input excites the component; otherwise only ratios of its parameters are identifiable."""
    return not all(is_free(run.recording, run.experiment.inputs) for run in runs)
