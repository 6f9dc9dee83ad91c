"""A run of the steer test, prepared for comparison.

The imposed motion is reconstructed, the measured outputs are reduced to harmonics, and their noise is estimated.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from fmus.support.errors import InputError
from motofmi.gap.preprocessing.excitation_phase import Phase, phase_of
from motofmi.gap.preprocessing.harmonics import ORDERS, Noise, Reduction, noise_of, reduction_of, variance_of
from motofmi.gap.preprocessing.mains_interference import interference_lines
from motofmi.gap.preprocessing.reconstructed_motion import ORDERS as MOTION_ORDERS
from motofmi.gap.preprocessing.reconstructed_motion import (
    MotionReconstruction,
    ReconstructedMotion,
    motion_reconstruction,
)
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import LEAST_SIGNAL, slower, uniform, white_noise

SHORTEST_RUN = 20.0  # s: a shorter run has too few windows to separate the noise from the misfit
SWEPT_SHARE = 0.9  # least share of a swept motion's power that is on its harmonics
COMPARED_RATE = 250.0  # Hz: sufficient to simulate backlash and friction; faster recordings are decimated
STEPS_PER_CYCLE = 10  # simulation steps per cycle of the highest harmonic
PASS_BAND = 0.4  # pass band of the decimation over the reduced sampling rate
CACHED = 16  # sets of times whose motion is cached: those of a simulation, and of the delays that a screening tries
KNOT_REFINEMENTS = 3  # most refinements of the reconstruction's knots where it does not follow the measured angle
# Chi-square of the four data of the first order in a window above which knots are added. It is exceeded by chance in
# one of 2000 windows; additional knots increase the variance of the motion only slightly.
WINDOW_CHI2 = 20.0
# Relative standard deviation of the gain of all sensors except that of the effort: calibration and mounting.
GAIN_ERROR = 0.02


class NotSweptError(InputError):
    """The imposed motion is no swept or stepped sine; it can be simulated over time, but not compared on harmonics."""


@dataclass(frozen=True)
class Output:
    """A measured output (n,) of a run, and its data y (m,) on harmonics.

    deviation (m,) is the standard deviation of the data; motion_variance (m,) is the part of their variance that is due
    to errors of the reconstructed motion. The errors are independent except for that of the sensor's gain: their
    covariance is D^2 + g^2 y y', with D = diag(deviation) and g = gain_error [1].
    """

    column: str
    measured: np.ndarray
    noise: Noise
    data: np.ndarray
    deviation: np.ndarray
    motion_variance: np.ndarray
    gain_error: float = 0.0

    def over_noise(self, reduced: np.ndarray) -> np.ndarray:
        """Reduced signals (m, ...) multiplied by the inverse root of the covariance of the errors [1]."""
        z, y = (reduced.T / self.deviation).T, self.data / self.deviation
        if not self.gain_error:
            return z
        power = float(y @ y)
        share = 1 - 1 / np.sqrt(1 + self.gain_error**2 * power)
        return z - np.multiply.outer(y, share / power * (y @ z))

    def with_remaining_noise(self, modelled: np.ndarray, reduction: Reduction) -> "Output":
        """The output with the noise spectrum of the residuals of a model (n,).

        High orders that an effect of the model excites are then no part of the noise.
        """
        noise = noise_of(reduction, self.measured - modelled)
        return replace(self, noise=noise, deviation=np.sqrt(variance_of(reduction, noise) + self.motion_variance))


@dataclass(repr=False)
class SteerTestRun:
    """A recording of an imposed motion on its harmonics: one output after the other, the effort first.

    The effort is the force or torque that imposes the motion.
    """

    recording: Recording
    motion: ReconstructedMotion
    reduction: Reduction
    outputs: tuple[Output, ...]
    unit: str  # of the imposed motion
    notes: tuple[str, ...] = ()
    cache: dict = field(default_factory=dict)  # values of the motion, by times

    def __repr__(self) -> str:
        columns = ", ".join(output.column for output in self.outputs)
        return f"SteerTestRun({self.name!r}, {len(self.recording.time)} samples, outputs {columns})"

    @cached_property
    def data(self) -> np.ndarray:
        """The reduced data (m,) of all outputs, transformed to independent errors, in the units of the outputs."""
        return np.concatenate([output.over_noise(output.data) * output.deviation for output in self.outputs])

    @cached_property
    def deviation(self) -> np.ndarray:
        """The standard deviation (m,) of the data."""
        return np.concatenate([output.deviation for output in self.outputs])

    @property
    def effort(self) -> Output:
        """The output that imposes the motion: force or torque."""
        return self.outputs[0]

    def with_remaining_noise(self, modelled: np.ndarray) -> "SteerTestRun":
        """The run with the noise spectra of a model's residuals, for simulated outputs (n, ny)."""
        beside = [
            output.with_remaining_noise(y, self.reduction) for output, y in zip(self.outputs, modelled.T, strict=True)
        ]
        return replace(self, outputs=tuple(beside))

    def reduced(self, y: np.ndarray) -> np.ndarray:
        """Signals of the outputs (n, ny, ...) reduced as the data are: (m, ...) over the noise."""
        each = self.reduction.reduce(y.reshape(len(y), -1)).reshape(-1, *y.shape[1:])
        return np.concatenate([output.over_noise(each[:, i]) for i, output in enumerate(self.outputs)])

    @property
    def name(self) -> str:
        """The name of the recording."""
        return self.recording.name

    def motion_at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The imposed angle, rate and acceleration (n,) at times (n,) [s]; those used last are cached."""
        key = (len(time), float(time[0]), float(time[-1]))
        if key in self.cache:
            self.cache[key] = self.cache.pop(key)  # the last one to be removed
        else:
            if len(self.cache) == CACHED:
                self.cache.pop(next(iter(self.cache)))
            self.cache[key] = self.motion(np.clip(time, *self.recording.time[[0, -1]]))
        return self.cache[key]

    @cached_property
    def steps_per_sample(self) -> int:
        """Simulation steps per sample: more than one where a cycle of the highest harmonic has few samples."""
        return int(np.ceil(STEPS_PER_CYCLE * max(c.frequency for c in self.reduction.columns) / self.recording.rate))

    @cached_property
    def nodes(self) -> np.ndarray:
        """The times at which the run is simulated [s]."""
        time, steps = self.recording.time, self.steps_per_sample
        return np.interp(np.arange((len(time) - 1) * steps + 1) / steps, np.arange(len(time)), time)

    @property
    def duration(self) -> float:
        """The time from zero to the end of the run [s]."""
        return float(self.recording.time[-1] + 1 / self.recording.rate)


def prepare_steer_test_run(
    recording: Recording, imposed: str, measured: str, command: str, further: Sequence[str] = ()
) -> SteerTestRun:
    """The run of a servo-driven test, from the names of its channels.

    The phase is that of the command, or that of the imposed motion where no command is recorded. `further` are outputs
    that are compared as well, where the recording has them and they are not constant. Raises InputError for a run that
    is too short or has no excitation, and NotSweptError for a motion that is no sine of slowly changing frequency.
    """
    recording, notes = uniform(recording)
    if np.ptp(recording.time) < SHORTEST_RUN:
        raise InputError(
            f"{recording.name}: {np.ptp(recording.time):.3g} s are too short to separate the noise from the misfit; "
            f"expected at least {SHORTEST_RUN:g} s"
        )
    reference = command
    if np.ptp(recording.columns.get(command, 0.0)) == 0:
        reference = imposed
        notes = (*notes, f"no {command} in {recording.name}: the phase is taken from {imposed}")
    phase = phase_of(recording[reference], recording.rate, reference == imposed, recording.broken)
    factor = _decimation(recording, phase) if phase else 1
    if factor > 1:
        recording = slower(recording, factor)
        notes = (
            *notes,
            f"{recording.name} is compared at {recording.rate:.4g} Hz, which is sufficient for {ORDERS} harmonics "
            "of its motion",
        )
        phase = phase_of(recording[reference], recording.rate, reference == imposed, recording.broken)
    if phase is None:
        raise _not_swept(recording, imposed)
    time, angle = recording.time, recording[imposed]
    reduction = reduction_of(phase, recording.rate)
    interference = interference_lines(reduction, recording[measured])
    if interference:
        reduction = reduction_of(phase, recording.rate, interference)
        notes = (
            *notes,
            f"{recording.name}: {measured} has mains interference at {', '.join(f'{f:.4g}' for f in interference)} Hz, "
            "which is left out",
        )
    if _share_on_harmonics(reduction, angle) < SWEPT_SHARE:
        raise _not_swept(recording, imposed)
    angle_noise = noise_of(reduction, angle)
    signal = np.concatenate([angle[first:last] for first, last in phase.windows])
    if np.std(signal) < LEAST_SIGNAL * np.sqrt(np.median(angle_noise.density)):
        raise _no_excitation(recording, imposed, signal, float(np.sqrt(np.median(angle_noise.density))))
    reduced_angle, angle_variance = reduction.reduce(angle), variance_of(reduction, angle_noise)
    orders = _resolved_orders(reduction, reduced_angle, angle_variance)
    reconstruction = _reconstruction(angle, phase, reduction, angle_variance, orders, time)
    outputs: list[Output] = []
    for column in (measured, *(name for name in further if np.ptp(recording.columns.get(name, 0.0)) > 0)):
        y = recording[column]
        noise, data = noise_of(reduction, y), reduction.reduce(y)
        motion_variance = _variance_from_motion(reduction, reduced_angle, data, angle_variance, reconstruction)
        outputs.append(
            Output(
                column,
                y,
                noise,
                data,
                np.sqrt(variance_of(reduction, noise) + motion_variance),
                motion_variance,
                GAIN_ERROR if outputs else 0.0,
            )
        )
    return SteerTestRun(
        recording, reconstruction.motion(angle), reduction, tuple(outputs), recording.units[imposed], notes
    )


def _decimation(recording: Recording, phase: Phase) -> int:
    """The integer factor by which a recording can be decimated."""
    top = max(float(phase.frequency[first:last].max()) for first, last in phase.windows)
    return int(recording.rate / max(COMPARED_RATE, ORDERS * top / PASS_BAND))


def _not_swept(recording: Recording, imposed: str) -> InputError:
    """The error for a run that cannot be compared on harmonics: its motion is no swept sine, or is hidden by noise."""
    noise = white_noise(recording[imposed])
    if np.std(recording[imposed]) < LEAST_SIGNAL * noise:
        return _no_excitation(recording, imposed, recording[imposed], noise)
    return NotSweptError(
        f"{recording.name}: {imposed} follows no swept or stepped sine, so there are no harmonics to compare on"
    )


def _no_excitation(recording: Recording, imposed: str, signal: np.ndarray, noise: float) -> InputError:
    """The error for an imposed motion (n,) that does not exceed its noise (standard deviation)."""
    return InputError(
        f"{recording.name}: no excitation: {imposed} moves by {np.std(signal):.2g} {recording.units[imposed]} (rms), "
        f"its noise is {noise:.2g}"
    )


def _share_on_harmonics(reduction: Reduction, y: np.ndarray) -> float:
    """The share of a signal's power (n,) on the harmonics, within the windows."""
    left = sum(float(part @ part) for part in reduction.residuals(y))
    whole = sum(float(np.sum((y[first:last] - y[first:last].mean()) ** 2)) for first, last, _ in reduction.outside)
    return 1 - left / max(whole, 1e-300)


def _resolved_orders(reduction: Reduction, reduced_angle: np.ndarray, variance: np.ndarray) -> tuple[int, ...]:
    """The orders at which the imposed motion exceeds its noise, with the first always among them."""
    order = np.array([c.order for c in reduction.columns])
    over_noise = reduced_angle**2 / variance
    chi2 = {k: np.mean(over_noise[order == k]) for k in MOTION_ORDERS if np.any(order == k)}
    return (1, *(k for k, e in chi2.items() if e > 1 + 4 * np.sqrt(2 / np.count_nonzero(order == k))))


def _reconstruction(
    angle: np.ndarray, phase: Phase, reduction: Reduction, variance: np.ndarray, orders: Sequence[int], time: np.ndarray
) -> MotionReconstruction:
    """The reconstruction of the motion, with closer knots where it does not follow the angle (n,) within its noise."""
    first, closer = np.array([c.order == 1 for c in reduction.columns]), np.ones(len(time))
    window = np.array([c.window for c in reduction.columns])[first]
    reconstruction = motion_reconstruction(time, phase, orders)
    for _ in range(KNOT_REFINEMENTS):
        missed = reduction.reduce(angle - reconstruction.motion(angle)(time)[0])[first] ** 2 / variance[first]
        missed_windows = np.flatnonzero(np.bincount(window, missed) > WINDOW_CHI2)
        if not len(missed_windows):
            break
        for begin, end in (phase.windows[i] for i in missed_windows):
            closer[max(2 * begin - end, 0) : 2 * end - begin] *= 2.0  # adjacent windows as well, since splines overlap
        reconstruction = motion_reconstruction(time, phase, orders, closer)
    return reconstruction


def _variance_from_motion(
    reduction: Reduction,
    angle: np.ndarray,
    data: np.ndarray,
    variance: np.ndarray,
    reconstruction: MotionReconstruction,
) -> np.ndarray:
    """The variance (m,) due to the noise of the reconstructed motion.

    It is that of the response to this noise, with the impedance that is measured at the first order.
    """
    columns = reduction.columns
    first = [i for i, c in enumerate(columns) if c.order == 1 and c.degree == 0]
    seen = np.array([(i, j) for i, j in pairwise(first) if columns[i].window == columns[j].window])  # cosine and sine
    (u, v), (p, q) = angle[seen].T, data[seen].T
    frequency = np.array([columns[i].frequency for i, _ in seen])
    order = np.argsort(frequency)
    impedance = ((p - 1j * q) / (u - 1j * v))[order]  # of a motion Re (u - i v) e^(i phi)
    frequency = frequency[order]

    def response(k: int) -> np.ndarray:
        at = k * reconstruction.phase.frequency
        beyond = np.maximum(at / frequency[-1], 1.0) ** 2  # where the handlebar's inertia dominates
        return np.interp(at, frequency, impedance) * beyond

    reconstructed = np.array([c.order in reconstruction.orders for c in columns])
    ends = np.cumsum([basis.shape[1] for _, _, basis in reduction.bases])
    masks = np.split(reconstructed, ends[:-1])
    bases = [(a, b, basis[:, mask]) for (a, b, basis), mask in zip(reduction.bases, masks, strict=True)]
    added = np.zeros(len(columns))
    added[reconstructed] = reconstruction.response_variance(bases, response) * variance[reconstructed]
    return added


def require_unclipped(recordings: Sequence[Recording]) -> None:
    """Raises InputError for a run with a clipped channel: clipping has the same response as a physical effect."""
    for recording in recordings:
        for warning in recording.warnings:
            if "clipped" in warning:
                raise InputError(
                    f"{recording.name}: {warning}; clipping has the same response as a physical effect, so that no "
                    "effect can be named; record within the range of the sensor"
                )
