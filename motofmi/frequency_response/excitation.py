"""Commanded motions of a test: stepped sine, linear sweep either way, multisine.

Each is a smooth function of time that starts and ends at rest, given with its rate, so that it can be sampled
at any rate. The defaults are the tests of the two papers: 2008 stepped sine, 2011 linear sweep.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi, radians

import numpy as np

Motion = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
REST = 2.0  # s; time without motion at the end, in which the rider's motion decays


@dataclass(frozen=True)
class Excitation:
    """A commanded angle of `duration` [s], and `motion(time (n,)) -> (angle (n,) [rad], rate (n,) [rad/s])`."""

    name: str
    duration: float
    motion: Motion


def sweep(
    start: float = 0.5, end: float = 12.0, duration: float = 200.0, amplitude: float = radians(2), ramp: float = 2.0
) -> Excitation:
    """A sine with a frequency that changes linearly from start to end [Hz]; end may be below start."""

    def motion(time):
        phase = 2 * pi * (start * time + (end - start) * time**2 / (2 * duration))
        frequency = 2 * pi * (start + (end - start) * time / duration)
        return amplitude * np.sin(phase), amplitude * frequency * np.cos(phase)

    return _from_rest(f"sweep_{start:g}_to_{end:g}_Hz", duration, motion, ramp)


def stepped_sine(frequencies: Sequence[float] | np.ndarray | None = None, seconds: float = 10.0,
                 amplitude: float = radians(4), ramp: float = 1.0) -> Excitation:  # fmt: skip
    """A sine of constant amplitude that stays `seconds` at each of the frequencies [Hz], in the order given.

    The frequency changes within half a second, without a jump in angle or rate.
    """
    levels = np.arange(0.5, 8.51, 0.5) if frequencies is None else np.asarray(frequencies, float)
    move = 0.5
    changes = np.diff(levels, prepend=levels[0])

    def motion(time):
        since = time[:, None] - seconds * np.arange(len(levels))
        risen, _, area = _smooth_step(np.clip(since / move, 0, 1))
        gone = move * area + np.maximum(since - move, 0)
        phase = 2 * pi * (levels[0] * time + gone @ changes)
        frequency = 2 * pi * (levels[0] + risen @ changes)
        return amplitude * np.sin(phase), amplitude * frequency * np.cos(phase)

    return _from_rest("stepped_sine", seconds * len(levels), motion, ramp)


def multisine(frequencies: Sequence[float] | np.ndarray | None = None, duration: float = 200.0,
              amplitude: float = radians(4), seed: int = 0, ramp: float = 2.0) -> Excitation:  # fmt: skip
    """All frequencies [Hz] at once with random phases, of equal angle amplitudes, with the given largest angle."""
    lines = np.arange(0.5, 12.01, 0.25) if frequencies is None else np.asarray(frequencies, float)
    phases = np.random.default_rng(seed).uniform(0, 2 * pi, len(lines))
    omega = 2 * pi * lines

    def sines(time):
        argument = np.multiply.outer(time, omega) + phases
        return np.sin(argument).sum(axis=1), np.cos(argument) @ omega

    largest = np.abs(sines(np.arange(0, duration, 1 / 256))[0]).max()

    def motion(time):
        angle, rate = sines(time)
        return amplitude / largest * angle, amplitude / largest * rate

    return _from_rest("multisine", duration, motion, ramp)


def _from_rest(name: str, duration: float, motion: Motion, ramp: float) -> Excitation:
    """The motion faded in and out over `ramp` [s], with standstill after it."""

    def faded(time):
        angle, rate = motion(time)
        inside = np.clip(np.minimum(time, duration - time), 0, ramp)
        rise, slope, _ = _smooth_step(inside / ramp)
        slope = slope / ramp * np.where(time < duration / 2, 1, -1)
        return rise * angle, rise * rate + slope * angle

    return Excitation(name, duration + REST, faded)


def _smooth_step(x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From 0 to 1 with three continuous derivatives, its slope and its integral.

    Coarser fades leave jumps in the acceleration, which a sampled torque shows as aliases.
    """
    value = x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3)
    return value, 140 * x**3 * (1 - x) ** 3, x**5 * (7 - 14 * x + 10 * x**2 - 2.5 * x**3)
