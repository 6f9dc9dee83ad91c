"""Blind cases that resemble real machines: a dominant effect, a weaker one outside the library, and imperfect recordings.

    J q'' = T - k q - c s - R_1(q, s, z_1, t) - R_2(q, s, z_2, t)

R_1 is an effect of `hidden_mechanisms`, in a form of the library or in another one. R_2 is in no library. Its size is a
share of that of R_1: both are measured as the rms of the part of their torque that no constant, deflection, rate or
acceleration explains, since the base takes up all else. Recordings are low-passed, with white sensor noise of 0.01 %
in every channel, and with time stamps that jitter; in half of the cases the sampling jitters with them, in the others
it is regular. Simulated by scipy's LSODA; nothing of the library is used.

Friction with rate and state: Ruina, J. Geophys. Res. 88 (1983) 10359-10370, regularised after Lapusta et al.,
J. Geophys. Res. 105 (2000) 23765-23789.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.signal import butter, lfilter, lsim

from tests.simulators.hidden_mechanisms import excitation, resistance
from tests.simulators.mechanism_cases import FAMILY, UNLIKE, sizes

FIRSTS = ("friction", "hardening", "hysteresis", "drag", "backlash", "asymmetry", "sine", "smooth_friction", "sinh_hardening",
          "thin_loop", "blunt_drag", "atan_backlash")  # fmt: skip
SETTINGS = ("driven", "imposed", "closed_loop", "mass_spring_damper")
KINDS = {"driven": ("random", "multisine", "chirp", "steps", "road"), "imposed": ("random", "multisine", "chirp")}
PERIODS, FINER = 40, 4  # of the mechanism's own frequency in a recording; steps of the output per sample
NOISE = 1e-4  # of a channel's rms
SHARES = (0.03, 0.2)  # of the second effect
SEEN = 0.03  # of the driving torque's rms: the least size of the first effect
Law = Callable[[float, float, float, float], tuple[float, float]]  # q, s, z, t -> torque, rate of z


@dataclass(frozen=True)
class RealLikeCase:
    """The truth (hidden is "none" where nothing is) and two recordings: times (n,) and columns (n,) by name."""

    number: int
    hidden: str
    second: str
    share: float
    setting: str
    jitter: str  # of the "sampling" or only of the "stamps"
    fitted: tuple[np.ndarray, dict[str, np.ndarray]]
    validation: tuple[np.ndarray, dict[str, np.ndarray]]
    near: dict[str, float]

    @property
    def family(self) -> str:
        """The family of the first effect, empty where nothing is hidden."""
        return (FAMILY | UNLIKE).get(self.hidden, "")


def bump(angle: float, rate: float, duration: float, p: dict) -> Law:
    """A quadratic and cubic spring with a smooth bump."""

    def law(q, s, z, t):
        u = q / angle
        return 0.4 * u**2 + 0.6 * u**3 + 0.7 * np.exp(-(((u - 0.35) / 0.15) ** 2)), 0.0

    return law


def warming(angle: float, rate: float, duration: float, p: dict) -> Law:
    """Stiffness and damping that settle exponentially after the start."""

    def law(q, s, z, t):
        return (p["k"] * q + p["c"] * s) * (1 - np.exp(-t / (0.3 * duration))), 0.0

    return law


def rate_and_state(angle: float, rate: float, duration: float, p: dict) -> Law:
    """Friction with a logarithmic dependence on rate and state; z is the logarithm of the state."""
    slow, length, direct, evolving = 1e-3 * rate, 0.02 * angle, 0.1, 0.15

    def law(q, s, z, t):
        return (
            direct * np.arcsinh(s / (2 * slow) * np.exp((1 + evolving * z) / direct)),
            (slow * np.exp(-z) - abs(s)) / length,
        )

    return law


def contact(angle: float, rate: float, duration: float, p: dict) -> Law:
    """Play on one side of a soft contact, whose force grows with the power 3/2 of its depth."""

    def law(q, s, z, t):
        return max(q / angle - 0.3, 0.0) ** 1.5, 0.0

    return law


def cogging(angle: float, rate: float, duration: float, p: dict) -> Law:
    """A torque that is periodic in the angle."""

    def law(q, s, z, t):
        return np.sin(2 * np.pi * q / (0.4 * angle)), 0.0

    return law


def nothing(q: float, s: float, z: float, t: float) -> tuple[float, float]:
    """No torque."""
    return 0.0, 0.0


SECONDS = {"bump": bump, "warming": warming, "rate_and_state": rate_and_state, "contact": contact, "cogging": cogging}


def draw(number: int, seed: int) -> RealLikeCase:
    """The case of that number; a quarter of the cases hide nothing."""
    rng = np.random.default_rng([seed, number])
    hidden = "none" if number % 4 == 0 else FIRSTS[(number - number // 4 - 1) % len(FIRSTS)]
    setting = SETTINGS[int(rng.integers(2 if hidden == "sine" else len(SETTINGS)))]
    second = "none" if hidden == "none" else list(SECONDS)[int(rng.integers(len(SECONDS)))]
    share = 0.0 if hidden == "none" else float(np.exp(rng.uniform(*np.log(SHARES))))
    jitter = ("sampling", "stamps")[int(rng.integers(2))]
    machine = Machine(rng, setting, hidden, second, share)
    fitted, validation = (machine.recorded(rng, size, jitter) for size in (1.0, rng.uniform(0.6, 1.1)))
    near = {n: machine.p[n] * float(np.exp(0.5 * rng.normal())) for n in ("J", "k", "c")}
    return RealLikeCase(number, hidden, second, share, setting, jitter, fitted, validation, near)


class Machine:
    """A machine with random values, the size of its effects chosen in a first run."""

    def __init__(self, rng: np.random.Generator, setting: str, hidden: str, second: str, share: float):
        large = setting == "mass_spring_damper"  # hundreds of kilogrammes, kilonewtons, millimetres
        inertia = (300.0 if large else 0.1) * np.exp(rng.normal())
        stiffness = (1e6 if large else 10.0) * np.exp(rng.normal())
        self.frequency = np.sqrt(stiffness / inertia) / (2 * np.pi)
        damping = 2 * np.sqrt(inertia * stiffness) * rng.uniform(0.03, 0.2)
        self.angle = 1.2 if hidden == "sine" else (0.005 if large else 1.0) * float(np.exp(rng.uniform(-3, 0)))
        self.rate = 2 * np.pi * self.frequency * self.angle
        self.p = {"J": inertia, "k": stiffness, "c": damping, "sliding": 1e-3 * self.rate}
        self.setting, self.duration = setting, PERIODS / self.frequency
        self.sampling = self.frequency * rng.uniform(40, 90)
        self.corner = self.frequency * rng.uniform(8, 15)
        self.time = np.arange(0, self.duration, 1 / (FINER * self.sampling))
        closed = setting == "closed_loop"
        self.feedback = (2 * stiffness * closed, 0.3 * np.sqrt(stiffness * inertia) * closed)  # by deflection and rate
        self.first: dict = {}
        self.second: Law = nothing
        drive = self.drive(rng)
        while hidden != "none":
            self.first = {hidden: sizes(rng, self.p, self.angle, self.linear_motion(drive)[1].std())[hidden]}
            made = self.motion(drive)
            beyond = self.beyond_linear(made, self._first_law)
            if beyond > SEEN * made[2].std() or hidden == "sine":
                unit = SECONDS[second](self.angle, self.rate, self.duration, self.p)
                self.second = times(share * beyond / self.beyond_linear(made, unit), unit)
                break
            drive = self.drive(rng)

    def _first_law(self, q: float, s: float, z: float, t: float) -> tuple[float, float]:
        torque, zr = resistance(self.p, self.first, q, s, z, t, self.duration)
        return torque - self.p["k"] * q - self.p["c"] * s, zr

    def drive(self, rng: np.random.Generator, size: float = 1.0) -> Callable[..., np.ndarray]:
        """A drive with which the linear mechanism reaches its angle times a size."""
        kinds = KINDS.get(self.setting, KINDS["driven"])
        unit = excitation(kinds[int(rng.integers(len(kinds)))], rng, self.duration, 2.5 * self.frequency, 1.0)
        factor = size * self.angle / np.abs(self.linear_motion(unit)[0]).max()
        return lambda t, *order: factor * unit(t, *order)

    def linear_motion(self, drive: Callable[..., np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Deflection and driving torque (n,) on the fine grid of the mechanism without effects."""
        p, (stiff, slow), wanted = self.p, self.feedback, drive(self.time)
        if self.setting == "imposed":
            return wanted, p["J"] * drive(self.time, 2) + p["c"] * drive(self.time, 1) + p["k"] * wanted
        force = stiff * wanted if self.setting == "closed_loop" else wanted
        system = ([1.0], [p["J"], p["c"] + slow, p["k"] + stiff])
        q = lsim(system, force, self.time)[1]
        return q, force - stiff * q - slow * np.gradient(q, self.time)

    def motion(self, drive: Callable[..., np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Deflection, rate and driving torque (n,) on the fine grid."""
        p, imposed = self.p, self.setting == "imposed"
        stiff, slow = self.feedback

        def torque(t, q, s):
            return stiff * (drive(t) - q) - slow * s if self.setting == "closed_loop" else drive(t)

        def rates(t, x):
            q, s = (drive(t), drive(t, 1)) if imposed else x[:2]
            (one, z1), (two, z2) = self._first_law(q, s, x[2], t), self.second(q, s, x[3], t)
            a = 0.0 if imposed else (torque(t, q, s) - p["k"] * q - p["c"] * s - one - two) / p["J"]
            return [0.0 if imposed else s, a, z1, z2]

        made = solve_ivp(rates, self.time[[0, -1]], np.zeros(4), "LSODA", self.time, rtol=1e-7, atol=1e-10,
                         max_step=4 * self.time[1])  # fmt: skip
        if not imposed:
            q, s = made.y[:2]
            return q, s, np.array([torque(*row) for row in zip(self.time, q, s, strict=True)])
        q, s, a = (drive(self.time, order) for order in range(3))
        rows = zip(q, s, a, *made.y[2:], self.time, strict=True)
        return q, s, np.array([p["J"] * a + p["k"] * q + p["c"] * s + self._first_law(q, s, z1, t)[0]
                               + self.second(q, s, z2, t)[0] for q, s, a, z1, z2, t in rows])  # fmt: skip

    def beyond_linear(self, made: tuple[np.ndarray, np.ndarray, np.ndarray], law: Law) -> float:
        """The rms of a law's torque in a motion that a constant, deflection, rate and acceleration do not explain."""
        q, s, _ = made
        motion, z = CubicSpline(self.time, np.column_stack([q, s])), np.zeros(len(q))
        if any(law(*row)[1] for row in zip(q[1::99], s[1::99], z[1::99], self.time[1::99], strict=True)):
            z = solve_ivp(lambda t, z: [law(*motion(t), z[0], t)[1]], self.time[[0, -1]], [0.0], "LSODA", self.time,
                          rtol=1e-6, atol=1e-9, max_step=4 * self.time[1]).y[0]  # fmt: skip
        torque = np.array([law(*row)[0] for row in zip(q, s, z, self.time, strict=True)])
        linear = np.column_stack([np.ones(len(q)), q, s, np.gradient(s, self.time)])
        linear /= np.linalg.norm(linear, axis=0)
        return float(np.std(torque - linear @ np.linalg.lstsq(linear, torque, rcond=None)[0]))

    def recorded(self, rng: np.random.Generator, size: float, jitter: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Time stamps (n,) and columns (n,) of a run with a drive of its own."""
        q, _, torque = self.motion(self.drive(rng, size))
        low = butter(2, self.corner, fs=FINER * self.sampling)
        regular = np.arange(2, int(self.duration * self.sampling) - 2) / self.sampling
        jittered = regular + rng.uniform(0.02, 0.15) / self.sampling * rng.uniform(-1, 1, len(regular))
        names = ("force", "displacement") if self.setting == "mass_spring_damper" else ("torque", "angle")
        columns = {}
        for name, signal in zip(names, (torque, q), strict=True):
            y = CubicSpline(self.time, lfilter(*low, signal))(jittered if jitter == "sampling" else regular)
            columns[name] = y + NOISE * np.std(y) * rng.standard_normal(len(y))
        return jittered, columns


def times(factor: float, law: Law) -> Law:
    """A law with its torque times a factor."""

    def scaled(q, s, z, t):
        torque, zr = law(q, s, z, t)
        return factor * torque, zr

    return scaled
