"""A run of any component, prepared for comparison over time, as cosine coefficients of blocks.

The excitation is arbitrary. The run is cut into segments of a few periods with unknown initial states: over
long segments small errors accumulate to a phase error, so that a fit has many minima, and an unstable component
cannot be simulated at all.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.ndimage import uniform_filter1d

from fmus.support.errors import InputError
from motofmi.gap.experiments.input_output import InputOutputExperiment
from motofmi.gap.preprocessing.blocks import Blocks, blocks_of
from motofmi.gap.preprocessing.flexible_noise_model import Density
from motofmi.gap.preprocessing.input_interpolation import (
    ABOVE_NOISE,
    CLOSEST,
    KINDS,
    LEAST_PER_PERIOD,
    NOISELESS,
    InterpolatedInputs,
    highest_frequency,
    input_function,
    motion_functions,
    resolved_frequency,
)
from motofmi.gap.preprocessing.mains_interference import without_mains_interference
from motofmi.gap.preprocessing.undisturbed_intervals import uninterrupted
from motofmi.recordings.quality import clipped
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import is_white, slower, uniform, white_noise

FEWEST = 200  # samples
POINTS = 8  # simulation steps per cycle of the highest frequency
MOST_POINTS = 40_000  # simulation steps of one run
PERIODS = 6.0  # of the motion's mean frequency in a segment
IMPOSED_PERIODS = 60.0  # the same where a state is imposed: the effect of other initial states decays
SHORTEST_SEGMENT = 100  # samples
ACCURACY = 3e-4  # least noise over a signal's rms: no model of a real component is more accurate
FASTER, MOST_SAMPLES = (
    20,
    6000,
)  # sampling rate over highest frequency, and samples, above which a recording is decimated
NEIGHBOURS = 9  # cosines over which a variance is averaged
# ratio of an imposed motion's power to its noise up to which the run is compared: there 1 % of the acceleration's power
# is noise
CLEAR = 100.0
BAND_OF_MOTION = (
    "{}: compared up to {:.3g} Hz: beyond, the acceleration of the recorded {} is not resolved from its noise or by "
    "its samples"
)
EDGE = 0.02  # share of the recording left out at each end of an imposed motion, where its acceleration is not known


@dataclass(repr=False)
class SampledRun:
    """A recording as cosine coefficients of its blocks: data (m,) and their standard deviation (m,)."""

    recording: Recording
    experiment: InputOutputExperiment
    measured: np.ndarray  # (n, outputs)
    inputs: InterpolatedInputs
    stretches: list[tuple[int, int]]  # without gaps
    segments: list[tuple[int, int]]
    finer: int  # simulation steps per sample
    reduction: Blocks
    densities: list[Density]
    noise_source: str
    data: np.ndarray
    deviation: np.ndarray
    notes: tuple[str, ...] = ()
    noise_from_model: bool = False
    kind: str = KINDS[0]  # interpolation of the inputs
    input_variance: np.ndarray | None = None  # (m,) variance due to the inputs between their samples
    guess: dict[Any, dict[str, Any]] = field(
        default_factory=dict
    )  # initial guesses of simulations, by segment, and by model and segment

    def __repr__(self) -> str:
        inputs, outputs = (", ".join(names) for names in (self.experiment.inputs, self.experiment.outputs))
        return f"SampledRun({self.name!r}, {len(self.recording.time)} samples, inputs {inputs or 'none'}, outputs {outputs})"


    @property
    def name(self) -> str:
        return self.recording.name

    @property
    def unit(self) -> str:
        """The unit of the motion by whose amplitude parts of a run are distinguished."""
        return self.recording.units[self.experiment.imposed or self.experiment.outputs[0]]

    @property
    def duration(self) -> float:
        """From time zero to the end of the run [s]."""
        return float(self.recording.time[-1] + 1 / self.recording.rate)

    def motion_at(self, time: np.ndarray) -> tuple[np.ndarray]:
        """The motion (n,) at times (n,)."""
        return (
            np.interp(time, self.recording.time, self.recording[self.experiment.imposed or self.experiment.outputs[0]]),
        )

    def with_densities(self, densities: list[Density], source: str) -> "SampledRun":
        """The run with other noise densities."""
        least = [(ACCURACY * np.std(y)) ** 2 for y in self.measured.T]
        densities = [d.at_least(x) for d, x in zip(densities, least, strict=True)]
        deviation = self.reduction.deviations(densities)
        if self.input_variance is not None:
            deviation = np.sqrt(deviation**2 + self.input_variance)
        return replace(self, densities=densities, noise_source=source, deviation=deviation)

    def with_input_variance(self, difference: np.ndarray) -> "SampledRun":
        """The run with a further variance: the squared change (m,) of a model's output with the
        interpolation of its inputs."""
        sizes = [kept for _, _, kept in self.reduction.spans for _ in range(self.reduction.outputs)]
        parts = np.split(difference**2, np.cumsum(sizes)[:-1])
        smooth = np.concatenate([uniform_filter1d(part, min(NEIGHBOURS, len(part)), mode="nearest") for part in parts])
        return replace(self, input_variance=smooth).with_densities(self.densities, self.noise_source)

    def with_interpolation(self, kind: str) -> "SampledRun":
        """The run with another interpolation of its inputs."""
        return replace(self, inputs=_interpolated_inputs(self.recording, self.experiment, kind), kind=kind, guess={})

    @cached_property
    def noiseless(self) -> "SampledRun":
        """The run with the imposed motion without its noise; itself where nothing is imposed."""
        return self.with_interpolation(NOISELESS) if self.experiment.imposed else self

    def with_initial_guesses(self, guess: Mapping[Any, Any]) -> "SampledRun":
        """The run with other initial guesses of its simulations."""
        return replace(self, guess={key: dict(known) for key, known in guess.items()})

    def scaled(self, factor: float) -> "SampledRun":
        """The run with its excitation scaled by a factor; the response is scaled as that of a linear component."""
        measured = factor * self.measured
        return replace(
            self, inputs=self.inputs.scaled(factor), measured=measured, data=self.reduction.reduce(measured), guess={}
        )

    def cut(self, length: int) -> "SampledRun":
        """The run in segments of `length` samples, each with its own initial states."""
        segments: list[tuple[int, int]] = []
        for first, last in self.stretches:
            edges = np.linspace(first, last, max((last - first) // max(length, 8), 1) + 1).astype(int)
            segments += [(int(a), int(b)) for a, b in pairwise(edges)]
        reduction = blocks_of(
            segments, len(self.experiment.outputs), self.recording.rate, self.reduction_band, self.reduction.compared
        )
        return replace(self, segments=segments, reduction=reduction, data=reduction.reduce(self.measured), guess={},
                       input_variance=None, deviation=reduction.deviations(self.densities))  # fmt: skip

    @cached_property
    def middle_frequency(self) -> float:
        """The power-weighted mean frequency [Hz] of the first output, where it exceeds its noise.

        It is a property of the motion: the power of its differences grows with the frequency, so that their mean
        frequency moves with the sampling rate and with the noise.
        """
        y = self.measured[:, 0] - self.measured[:, 0].mean()
        window = np.hanning(len(y))
        power, cycles = np.abs(np.fft.rfft(y * window)) ** 2, np.fft.rfftfreq(len(y))
        clear = power > ABOVE_NOISE * white_noise(y) ** 2 * np.sum(window**2)
        mean = float(np.sum(power[clear] * cycles[clear]) / max(np.sum(power[clear]), 1e-300))
        return max(mean * self.recording.rate, 2 / self.duration)

    @property
    def reduction_band(self) -> float:
        """The frequency up to which the run is compared [Hz]."""
        return max(c.frequency for c in self.reduction.columns)


def prepare_sampled_run(recording: Recording, experiment: InputOutputExperiment) -> SampledRun:
    """The run with a first guess of its noise.

    Missing and clipped samples are left out of the comparison. Raises InputError for a run that is too short, or an
    output that is constant or white noise that no input explains.
    """
    recorded = len(recording.time)
    recording, bridged = uniform(recording, bridged=1.0)
    at_limits, clipping = _at_limits(recording.from_zero(), experiment)
    recording, interference = without_mains_interference(recording.from_zero(), experiment.inputs, experiment.outputs)
    recording, reduced = _reduced(recording, experiment)
    notes = (*bridged, *clipping, *interference, *reduced)
    if min(recorded, len(recording.time)) < FEWEST:
        raise InputError(
            f"{recording.name}: {len(recording.time)} samples are too few to separate noise from a gap; expected at "
            f"least {FEWEST}"
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
    return sampled_run(recording, experiment, notes, at_limits)


def _at_limits(
    recording: Recording, experiment: InputOutputExperiment
) -> tuple[dict[str, list[tuple[float, float]]], tuple[str, ...]]:
    """The times [s] between which each output, or the imposed motion, is held by a limit, and notes on them."""
    found: dict[str, list[tuple[float, float]]] = {}
    notes = []
    for name in dict.fromkeys([*experiment.outputs, *filter(None, [experiment.imposed])]):
        y, time = recording[name], recording.time
        for sign in (1.0, -1.0):
            at = clipped(sign * y)
            if not len(at):
                continue
            beside = np.concatenate([[-np.inf], time, [np.inf]])
            ends = np.split(at, np.flatnonzero(np.diff(at) > 1) + 1)
            found.setdefault(name, []).extend((float(beside[e[0]]), float(beside[e[-1] + 2])) for e in ends)
            notes.append(
                f"{recording.name}: {len(at)} samples of {name} at its limit of {y[at[0]]:.4g} {recording.units[name]} "
                "are left out of the comparison: the sensor or a stop may clip them"
            )
    return found, tuple(notes)


def sampled_run(
    recording: Recording,
    experiment: InputOutputExperiment,
    notes: tuple[str, ...] = (),
    at_limits: Mapping[str, Sequence[tuple[float, float]]] = MappingProxyType({}),
) -> SampledRun:
    """The run of a recording on a regular grid, without checks, with a first guess of its noise.

    at_limits are the times between which outputs, or the imposed motion, are not compared.
    """
    time, rate = recording.time, recording.rate
    measured = np.column_stack([recording[name] for name in experiment.outputs])
    deviations = [white_noise(y) for y in measured.T]
    highest = max(highest_frequency(y, rate) for y in measured.T)
    band = min(1.3 * highest + 4 * rate / len(time), rate / 2)
    if experiment.imposed:
        clear = min(resolved_frequency(recording[experiment.imposed], rate, CLEAR), rate / (LEAST_PER_PERIOD * CLOSEST))
        if clear < band:
            notes = (*notes, BAND_OF_MOTION.format(recording.name, clear, experiment.imposed))
        band = min(band, clear)
    edge = int(EDGE * len(time)) if experiment.imposed else 0
    stretches = [s for s in uninterrupted(~recording.broken, edge) if s[1] - s[0] >= SHORTEST_SEGMENT // 2]
    if not stretches:
        raise InputError(f"{recording.name}: fewer than {SHORTEST_SEGMENT // 2} consecutive samples between its gaps; "
                         "record without gaps, "
                         "or cut the recording into parts without gaps")  # fmt: skip
    reduction = blocks_of(stretches, len(experiment.outputs), rate, band, _compared(recording, experiment, at_limits))
    finer = int(np.clip(np.ceil(POINTS * highest / rate), 1, max(MOST_POINTS // len(time), 1)))
    densities = [
        Density(np.array([0.0, rate / 2]), np.full(2, max(s, ACCURACY * np.std(y)) ** 2))
        for s, y in zip(deviations, measured.T, strict=True)
    ]
    whole = SampledRun(recording, experiment, measured, _interpolated_inputs(recording, experiment, KINDS[0]), stretches, stretches, finer, reduction, densities, "",
                    reduction.reduce(measured), reduction.deviations(densities), notes)  # fmt: skip
    periods = IMPOSED_PERIODS if experiment.imposed else PERIODS
    return whole.cut(max(int(periods * rate / whole.middle_frequency), SHORTEST_SEGMENT))


def _compared(
    recording: Recording, experiment: InputOutputExperiment, at_limits: Mapping[str, Sequence[tuple[float, float]]]
) -> np.ndarray | None:
    """Which samples (n, outputs) are neither bridged nor at a limit; None where all are compared."""
    everywhere = [*recording.bridged, *at_limits.get(experiment.imposed, ())]
    left_out = [recording.within([*everywhere, *at_limits.get(name, ())]) for name in experiment.outputs]
    return ~np.column_stack(left_out) if np.any(left_out) else None


def _reduced(recording: Recording, experiment: InputOutputExperiment) -> tuple[Recording, tuple[str, ...]]:
    """The recording at a lower rate, where its rate is far above the highest frequency in it."""
    wanted = [*experiment.outputs, *experiment.inputs]
    highest = max(highest_frequency(recording[n], recording.rate) for n in wanted if np.ptp(recording[n]) > 0)
    factor = int(recording.rate / (FASTER * highest))
    if factor < 2 or len(recording.time) < MOST_SAMPLES:
        return recording, ()
    factor = min(factor, len(recording.time) // (MOST_SAMPLES // 2))
    note = f"{recording.name}: reduced to {recording.rate / factor:.4g} Hz; its highest frequency is {highest:.3g} Hz"
    return slower(recording, factor), (note,)


def _interpolated_inputs(recording: Recording, experiment: InputOutputExperiment, kind: str) -> InterpolatedInputs:
    time = recording.time
    functions: dict[str, Any] = {
        n: input_function(time, recording[n], kind) for n in experiment.inputs if n != experiment.imposed
    }
    if experiment.imposed:
        seen = experiment.with_effects(())
        motion = motion_functions(time, recording[experiment.imposed], seen.rate, kind)  # type: ignore[attr-defined]
        functions |= {name or experiment.imposed: function for name, function in motion.items()}
    return InterpolatedInputs(functions, (float(time[0]), float(time[-1])))


def excited(runs: Sequence[SampledRun]) -> bool:
    """Whether any recorded input drives the component; otherwise only ratios of its parameters are identifiable."""
    return any(np.ptp(run.recording[n]) > 0 for run in runs for n in run.experiment.inputs)
