"""One run, made ready: its motion known between the samples, its measured outputs reduced, their noise known."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from fmus.errors import InputError
from identification.gap.data.hum import hum_of
from identification.gap.data.motion import ORDERS as MOTION_ORDERS
from identification.gap.data.motion import Rebuilding, Rebuilt, rebuilding
from identification.gap.data.phase import Phase, phase_of
from identification.gap.data.reduction import ORDERS, Noise, Reduction, noise_of, reduction_of, variance_of
from identification.recordings import Recording
from identification.sampling import LEAST_SIGNAL, slower, uniform, white_noise

SHORTEST = 20.0  # s: below it a run holds too few windows to tell noise from a gap
ON_HARMONICS = 0.9  # share of a swept motion's power that lies on its harmonics
RATE = 250.0  # Hz: what sharp effects need to be simulated well; faster recordings are compared at a part of their rate
POINTS = 10  # of a simulation per cycle of the fastest excitation
PASSED = 0.4  # of a reduced rate: the band that is left as it was
REFINED = 3  # times at most that a motion is rebuilt with knots half as far apart where it was astray
MISSED = 20.0  # chi-square of a window's four numbers of the first order: by chance once in 2000 windows, and closer knots do no harm
GAIN_ERROR = 0.02  # relative, of a sensor besides that of the effort: its calibration, and how it is mounted


class NotSweptError(InputError):
    """The imposed motion follows no swept or stepped sine: it can be simulated over time, but has no harmonics."""


@dataclass(frozen=True)
class Output:
    """A measured output (n,) of a run on its harmonics: data y (m,), and the variance that the rebuilt motion brings to them.

    Errors of the data are independent but for that of the sensor's gain: covariance D^2 + g^2 y y', D the deviation.
    """

    column: str
    measured: np.ndarray
    noise: Noise
    data: np.ndarray
    deviation: np.ndarray
    from_motion: np.ndarray
    gain_error: float = 0.0

    def over_noise(self, reduced: np.ndarray) -> np.ndarray:
        """Reduced signals (m, ...) in units of the noise, with unit covariance: along y, a gain counts for less."""
        z, y = (reduced.T / self.deviation).T, self.data / self.deviation
        if not self.gain_error:
            return z
        power = float(y @ y)
        share = 1 - 1 / np.sqrt(1 + self.gain_error**2 * power)
        return z - np.multiply.outer(y, share / power * (y @ z))

    def with_noise_beside(self, modelled: np.ndarray, reduction: Reduction) -> "Output":
        """The output with the noise of what a model (n,) leaves: a sharp effect's highest orders are then not in it."""
        noise = noise_of(reduction, self.measured - modelled)
        return replace(self, noise=noise, deviation=np.sqrt(variance_of(reduction, noise) + self.from_motion))


@dataclass
class Run:
    """A recording of an imposed motion on its harmonics: one output after the other, the effort first."""

    recording: Recording
    motion: Rebuilt
    reduction: Reduction
    outputs: tuple[Output, ...]
    unit: str  # of the imposed motion
    notes: tuple[str, ...] = ()
    known: dict = field(default_factory=dict)

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
        """The output that takes what is imposed."""
        return self.outputs[0]

    def with_noise_beside(self, modelled: np.ndarray) -> "Run":
        """The run with the noise of what a model leaves of the outputs (n, ny)."""
        beside = [output.with_noise_beside(y, self.reduction) for output, y in zip(self.outputs, modelled.T, strict=True)]
        return replace(self, outputs=tuple(beside))

    def reduced(self, y: np.ndarray) -> np.ndarray:
        """Signals of the outputs (n, ny, ...) as their data are: (m, ...) in units of the noise."""
        each = self.reduction.reduce(y.reshape(len(y), -1)).reshape(-1, *y.shape[1:])
        return np.concatenate([output.over_noise(each[:, i]) for i, output in enumerate(self.outputs)])

    @property
    def name(self) -> str:
        return self.recording.name

    def moved(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Imposed angle, rate and acceleration (n,) at times (n,); the last few times are kept, a fit asks again."""
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


def prepare(recording: Recording, imposed: str, measured: str, command: str, further: Sequence[str] = ()) -> Run:
    """The run of a servo-driven test. The phase is the command's, or the imposed motion's own where none is logged.

    further names outputs that are measured too, where the recording has them and they are not dead. Raises InputError for a run that is too
    short, that has no excitation, or no slowly changing frequency.
    """
    recording, notes = uniform(recording)
    if np.ptp(recording.time) < SHORTEST:
        raise InputError(f"{recording.name}: {np.ptp(recording.time):.3g} s are too short to tell noise from a gap; expected at least {SHORTEST:g} s")
    reference = command
    if np.ptp(recording.columns.get(command, 0.0)) == 0:
        reference = imposed
        notes = (*notes, f"no {command} in {recording.name}: the phase is taken from {imposed}")
    phase = phase_of(recording[reference], recording.rate, reference == imposed, recording.broken)
    factor = _faster(recording, phase) if phase else 1
    if factor > 1:
        recording = slower(recording, factor)
        notes = (*notes, f"{recording.name} is compared at {recording.rate:.4g} Hz, which is all that {ORDERS} harmonics of its motion need")
        phase = phase_of(recording[reference], recording.rate, reference == imposed, recording.broken)
    if phase is None:
        raise _not_swept(recording, imposed)
    time, angle = recording.time, recording[imposed]
    reduction = reduction_of(phase, recording.rate)
    hum = hum_of(reduction, recording[measured])
    if hum:
        reduction = reduction_of(phase, recording.rate, hum)
        notes = (*notes, f"{recording.name}: {measured} hums at {', '.join(f'{f:.4g}' for f in hum)} Hz, which is left out")
    if _on_harmonics(reduction, angle) < ON_HARMONICS:
        raise _not_swept(recording, imposed)
    angle_noise = noise_of(reduction, angle)
    signal = np.concatenate([angle[first:last] for first, last in phase.windows])
    if np.std(signal) < LEAST_SIGNAL * np.sqrt(np.median(angle_noise.density)):
        raise _still(recording, imposed, signal, float(np.sqrt(np.median(angle_noise.density))))
    moved, moved_variance = reduction.reduce(angle), variance_of(reduction, angle_noise)
    rebuilder = _followed(angle, phase, reduction, moved_variance, _orders(reduction, moved, moved_variance), time)
    outputs: list[Output] = []
    for column in (measured, *(name for name in further if np.ptp(recording.columns.get(name, 0.0)) > 0)):
        y = recording[column]
        noise, data = noise_of(reduction, y), reduction.reduce(y)
        from_motion = _through_the_motion(reduction, moved, data, moved_variance, rebuilder)
        outputs.append(Output(column, y, noise, data, np.sqrt(variance_of(reduction, noise) + from_motion), from_motion, GAIN_ERROR if outputs else 0.0))
    return Run(recording, rebuilder.motion(angle), reduction, tuple(outputs), recording.units[imposed], notes)


def _faster(recording: Recording, phase: Phase) -> int:
    """How many times faster than needed a recording is."""
    top = max(float(phase.frequency[first:last].max()) for first, last in phase.windows)
    return int(recording.rate / max(RATE, ORDERS * top / PASSED))


def _not_swept(recording: Recording, imposed: str) -> InputError:
    """Why a run without harmonics cannot be compared on them: it moves in another way, or hardly."""
    noise = white_noise(recording[imposed])
    if np.std(recording[imposed]) < LEAST_SIGNAL * noise:
        return _still(recording, imposed, recording[imposed], noise)
    return NotSweptError(f"{recording.name}: {imposed} follows no swept or stepped sine, so there are no harmonics to compare on")


def _still(recording: Recording, imposed: str, signal: np.ndarray, noise: float) -> InputError:
    return InputError(f"{recording.name}: no excitation: {imposed} moves by {np.std(signal):.2g} {recording.units[imposed]} (rms), its noise is {noise:.2g}")


def _on_harmonics(reduction: Reduction, y: np.ndarray) -> float:
    """The share of a signal's power (n,) in the windows that lies on the harmonics."""
    left = sum(float(part @ part) for part in reduction.residuals(y))
    whole = sum(float(np.sum((y[first:last] - y[first:last].mean()) ** 2)) for first, last, _ in reduction.outside)
    return 1 - left / max(whole, 1e-300)


def _orders(reduction: Reduction, moved: np.ndarray, variance: np.ndarray) -> tuple[int, ...]:
    """The orders that the imposed motion has beyond its noise, the first always among them."""
    order = np.array([c.order for c in reduction.columns])
    excess = {k: np.mean(moved[order == k] ** 2 / variance[order == k]) for k in MOTION_ORDERS if np.any(order == k)}
    return (1, *(k for k, e in excess.items() if e > 1 + 4 * np.sqrt(2 / np.count_nonzero(order == k))))


def _followed(angle: np.ndarray, phase: Phase, reduction: Reduction, variance: np.ndarray, orders: Sequence[int], time: np.ndarray) -> Rebuilding:
    """The rebuilding of the motion, with closer knots in windows where it does not follow the angle (n,) within its noise."""
    first, closer = np.array([c.order == 1 for c in reduction.columns]), np.ones(len(time))
    window = np.array([c.window for c in reduction.columns])[first]
    rebuilder = rebuilding(time, phase, orders)
    for _ in range(REFINED):
        missed = reduction.reduce(angle - rebuilder.motion(angle)(time)[0])[first] ** 2 / variance[first]
        astray = np.flatnonzero(np.bincount(window, missed) > MISSED)
        if not len(astray):
            break
        for begin, end in (phase.windows[i] for i in astray):
            closer[max(2 * begin - end, 0) : 2 * end - begin] *= 2.0  # and beside it: splines overlap
        rebuilder = rebuilding(time, phase, orders, closer)
    return rebuilder


def _through_the_motion(reduction: Reduction, angle: np.ndarray, data: np.ndarray, variance: np.ndarray, rebuilder: Rebuilding) -> np.ndarray:
    """What the noise of the rebuilt motion adds to the variance (m,): through the impedance, as measured at the first order."""
    columns = reduction.columns
    first = [i for i, c in enumerate(columns) if c.order == 1 and c.degree == 0]
    seen = np.array([(i, j) for i, j in pairwise(first) if columns[i].window == columns[j].window])  # cosine and sine
    (u, v), (p, q) = angle[seen].T, data[seen].T
    frequency = np.array([columns[i].frequency for i, _ in seen])
    order = np.argsort(frequency)
    impedance = ((p - 1j * q) / (u - 1j * v))[order]  # of a motion Re (u - i v) e^(i phi)
    frequency = frequency[order]

    def answer(k: int) -> np.ndarray:
        at = k * rebuilder.phase.frequency
        beyond = np.maximum(at / frequency[-1], 1.0) ** 2  # the bar's inertia takes over
        return np.interp(at, frequency, impedance) * beyond

    moved = np.array([c.order in rebuilder.orders for c in columns])
    ends = np.cumsum([basis.shape[1] for _, _, basis in reduction.bases])
    bases = [(a, b, basis[:, m]) for (a, b, basis), m in zip(reduction.bases, np.split(moved, ends[:-1]), strict=True)]
    added = np.zeros(len(columns))
    added[moved] = rebuilder.error_seen(bases, answer) * variance[moved]
    return added


def usable(recordings: Sequence[Recording]) -> None:
    """Raises InputError for a run whose measured channels were clipped: no verdict can rest on it."""
    for recording in recordings:
        for warning in recording.warnings:
            if "clipped" in warning:
                raise InputError(f"{recording.name}: {warning}; a clipped channel looks like a physical effect, so nothing can be named")
