"""One run of the steer test, prepared: its motion reconstructed, its measured outputs reduced to harmonics,
their noise estimated."""

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

SHORTEST = 20.0  # s: shorter runs have too few windows to separate noise from a gap
ON_HARMONICS = 0.9  # least share of a swept motion's power on its harmonics
RATE = 250.0  # Hz: sufficient to simulate backlash and friction; faster recordings are decimated
POINTS = 10  # simulation steps per cycle of the highest excitation frequency
PASSED = 0.4  # pass band of the decimation over the reduced rate
REFINED = 3  # refinements of the reconstruction's knots where it does not follow the measured angle
# chi-square of a window's four numbers of the first order: by chance once in 2000 windows, and closer knots do no harm
WINDOW_CHI2 = 20.0
GAIN_ERROR = 0.02  # relative, of a sensor besides that of the effort: its calibration, and how it is mounted


class NotSweptError(InputError):
    """The imposed motion follows no swept or stepped sine: it can be simulated over time, but has no harmonics."""


@dataclass(frozen=True)
class Output:
    """A measured output (n,) of a run on harmonics: data y (m,), and their variance due to errors of
    the reconstructed motion.

    Errors of the data are independent except for that of the sensor's gain: covariance D^2 + g^2 y y', D the deviation.
    """

    column: str
    measured: np.ndarray
    noise: Noise
    data: np.ndarray
    deviation: np.ndarray
    from_motion: np.ndarray
    gain_error: float = 0.0

    def over_noise(self, reduced: np.ndarray) -> np.ndarray:
        """Reduced signals (m, ...) over the noise, with unit covariance: components along y are
        reduced by the gain error."""
        z, y = (reduced.T / self.deviation).T, self.data / self.deviation
        if not self.gain_error:
            return z
        power = float(y @ y)
        share = 1 - 1 / np.sqrt(1 + self.gain_error**2 * power)
        return z - np.multiply.outer(y, share / power * (y @ z))

    def with_remaining_noise(self, modelled: np.ndarray, reduction: Reduction) -> "Output":
        """The output with the noise spectrum of what a model (n,) leaves, which excludes high orders
        that an effect excites."""
        noise = noise_of(reduction, self.measured - modelled)
        return replace(self, noise=noise, deviation=np.sqrt(variance_of(reduction, noise) + self.from_motion))


@dataclass(repr=False)
class SteerTestRun:
    """A recording of an imposed motion on its harmonics: one output after the other, the effort first."""

    recording: Recording
    motion: ReconstructedMotion
    reduction: Reduction
    outputs: tuple[Output, ...]
    unit: str  # of the imposed motion
    notes: tuple[str, ...] = ()
    known: dict = field(default_factory=dict)

    def __repr__(self) -> str:
        columns = ", ".join(output.column for output in self.outputs)
        return f"SteerTestRun({self.name!r}, {len(self.recording.time)} samples, outputs {columns})"


    @cached_property
    def data(self) -> np.ndarray:
        """The reduced data (m,) of all outputs, with independent errors."""
        return np.concatenate([output.over_noise(output.data) * output.deviation for output in self.outputs])

    @cached_property
    def deviation(self) -> np.ndarray:
        """The deviation (m,) of the data."""
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
        return self.recording.name

    def motion_at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Imposed angle, rate and acceleration (n,) at times (n,); the last few are cached."""
        key = (len(time), float(time[0]), float(time[-1]))
        if key not in self.known:
            if len(self.known) > 4:
                self.known.pop(next(iter(self.known)))
            self.known[key] = self.motion(np.clip(time, *self.recording.time[[0, -1]]))
        return self.known[key]

    @cached_property
    def finer(self) -> int:
        """Steps of a simulation per sample: a slow recording has too few for a loop that closes in a cycle."""
        return int(np.ceil(POINTS * max(c.frequency for c in self.reduction.columns) / self.recording.rate))

    @cached_property
    def nodes(self) -> np.ndarray:
        """The times at which the run is simulated [s]."""
        time = self.recording.time
        return np.interp(np.arange((len(time) - 1) * self.finer + 1) / self.finer, np.arange(len(time)), time)

    @property
    def duration(self) -> float:
        """From time zero to the end of the run [s]."""
        return float(self.recording.time[-1] + 1 / self.recording.rate)


def prepare_steer_test_run(
    recording: Recording, imposed: str, measured: str, command: str, further: Sequence[str] = ()
) -> SteerTestRun:
    """The run of a servo-driven test. The phase is the command's, or the imposed motion's own where none is logged.

    further names outputs that are measured too, where the recording has them and they are not dead. Raises InputError
    for a run that is too short, that has no excitation, or no slowly changing frequency.
    """
    recording, notes = uniform(recording)
    if np.ptp(recording.time) < SHORTEST:
        raise InputError(
            f"{recording.name}: {np.ptp(recording.time):.3g} s are too short to tell noise from a gap; expected at "
            f"least {SHORTEST:g} s"
        )
    reference = command
    if np.ptp(recording.columns.get(command, 0.0)) == 0:
        reference = imposed
        notes = (*notes, f"no {command} in {recording.name}: the phase is taken from {imposed}")
    phase = phase_of(recording[reference], recording.rate, reference == imposed, recording.broken)
    factor = _faster(recording, phase) if phase else 1
    if factor > 1:
        recording = slower(recording, factor)
        notes = (
            *notes,
            f"{recording.name} is compared at {recording.rate:.4g} Hz, which is all that {ORDERS} harmonics of its "
            "motion need",
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
    if _on_harmonics(reduction, angle) < ON_HARMONICS:
        raise _not_swept(recording, imposed)
    angle_noise = noise_of(reduction, angle)
    signal = np.concatenate([angle[first:last] for first, last in phase.windows])
    if np.std(signal) < LEAST_SIGNAL * np.sqrt(np.median(angle_noise.density)):
        raise _still(recording, imposed, signal, float(np.sqrt(np.median(angle_noise.density))))
    reduced_angle, angle_variance = reduction.reduce(angle), variance_of(reduction, angle_noise)
    reconstruction = _followed(angle, phase, reduction, angle_variance, _orders(reduction, reduced_angle, angle_variance), time)
    outputs: list[Output] = []
    for column in (measured, *(name for name in further if np.ptp(recording.columns.get(name, 0.0)) > 0)):
        y = recording[column]
        noise, data = noise_of(reduction, y), reduction.reduce(y)
        from_motion = _through_the_motion(reduction, reduced_angle, data, angle_variance, reconstruction)
        outputs.append(
            Output(
                column,
                y,
                noise,
                data,
                np.sqrt(variance_of(reduction, noise) + from_motion),
                from_motion,
                GAIN_ERROR if outputs else 0.0,
            )
        )
    return SteerTestRun(
        recording, reconstruction.motion(angle), reduction, tuple(outputs), recording.units[imposed], notes
    )


def _faster(recording: Recording, phase: Phase) -> int:
    """The factor by which a recording can be decimated."""
    top = max(float(phase.frequency[first:last].max()) for first, last in phase.windows)
    return int(recording.rate / max(RATE, ORDERS * top / PASSED))


def _not_swept(recording: Recording, imposed: str) -> InputError:
    """The error for a run that cannot be compared on harmonics: another motion, or hardly any."""
    noise = white_noise(recording[imposed])
    if np.std(recording[imposed]) < LEAST_SIGNAL * noise:
        return _still(recording, imposed, recording[imposed], noise)
    return NotSweptError(
        f"{recording.name}: {imposed} follows no swept or stepped sine, so there are no harmonics to compare on"
    )


def _still(recording: Recording, imposed: str, signal: np.ndarray, noise: float) -> InputError:
    return InputError(
        f"{recording.name}: no excitation: {imposed} moves by {np.std(signal):.2g} {recording.units[imposed]} (rms), "
        f"its noise is {noise:.2g}"
    )


def _on_harmonics(reduction: Reduction, y: np.ndarray) -> float:
    """The share of a signal's power (n,) on the harmonics, within the windows."""
    left = sum(float(part @ part) for part in reduction.residuals(y))
    whole = sum(float(np.sum((y[first:last] - y[first:last].mean()) ** 2)) for first, last, _ in reduction.outside)
    return 1 - left / max(whole, 1e-300)


def _orders(reduction: Reduction, reduced_angle: np.ndarray, variance: np.ndarray) -> tuple[int, ...]:
    """The orders at which the imposed motion exceeds its noise, with the first always among them."""
    order = np.array([c.order for c in reduction.columns])
    excess = {k: np.mean(reduced_angle[order == k] ** 2 / variance[order == k]) for k in MOTION_ORDERS if np.any(order == k)}
    return (1, *(k for k, e in excess.items() if e > 1 + 4 * np.sqrt(2 / np.count_nonzero(order == k))))


def _followed(
    angle: np.ndarray, phase: Phase, reduction: Reduction, variance: np.ndarray, orders: Sequence[int], time: np.ndarray
) -> MotionReconstruction:
    """The reconstruction of the motion, with closer knots in windows where it does not follow the angle
    (n,) within its noise."""
    first, closer = np.array([c.order == 1 for c in reduction.columns]), np.ones(len(time))
    window = np.array([c.window for c in reduction.columns])[first]
    reconstruction = motion_reconstruction(time, phase, orders)
    for _ in range(REFINED):
        missed = reduction.reduce(angle - reconstruction.motion(angle)(time)[0])[first] ** 2 / variance[first]
        missed_windows = np.flatnonzero(np.bincount(window, missed) > WINDOW_CHI2)
        if not len(missed_windows):
            break
        for begin, end in (phase.windows[i] for i in missed_windows):
            closer[max(2 * begin - end, 0) : 2 * end - begin] *= 2.0  # adjacent windows as well, since splines overlap
        reconstruction = motion_reconstruction(time, phase, orders, closer)
    return reconstruction


def _through_the_motion(
    reduction: Reduction,
    angle: np.ndarray,
    data: np.ndarray,
    variance: np.ndarray,
    reconstruction: MotionReconstruction,
) -> np.ndarray:
    """The variance (m,) due to the noise of the reconstructed motion, by the impedance measured at the first order."""
    columns = reduction.columns
    first = [i for i, c in enumerate(columns) if c.order == 1 and c.degree == 0]
    seen = np.array([(i, j) for i, j in pairwise(first) if columns[i].window == columns[j].window])  # cosine and sine
    (u, v), (p, q) = angle[seen].T, data[seen].T
    frequency = np.array([columns[i].frequency for i, _ in seen])
    order = np.argsort(frequency)
    impedance = ((p - 1j * q) / (u - 1j * v))[order]  # of a motion Re (u - i v) e^(i phi)
    frequency = frequency[order]

    def answer(k: int) -> np.ndarray:
        at = k * reconstruction.phase.frequency
        beyond = np.maximum(at / frequency[-1], 1.0) ** 2  # where the handlebar's inertia dominates
        return np.interp(at, frequency, impedance) * beyond

    reconstructed = np.array([c.order in reconstruction.orders for c in columns])
    ends = np.cumsum([basis.shape[1] for _, _, basis in reduction.bases])
    bases = [(a, b, basis[:, m]) for (a, b, basis), m in zip(reduction.bases, np.split(reconstructed, ends[:-1]), strict=True)]
    added = np.zeros(len(columns))
    added[reconstructed] = reconstruction.error_seen(bases, answer) * variance[reconstructed]
    return added


def require_unclipped(recordings: Sequence[Recording]) -> None:
    """Raises InputError for a run with a clipped channel: clipping looks like a physical effect."""
    for recording in recordings:
        for warning in recording.warnings:
            if "clipped" in warning:
                raise InputError(
                    f"{recording.name}: {warning}; a clipped channel looks like a physical effect, so nothing can be "
                    "named"
                )
