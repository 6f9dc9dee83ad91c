"""Blind cases on mechanisms: what is hidden in which, how it is driven, and how noisy its recording is, all drawn by number.

Sensors are off by a constant, those of inputs by a tenth of the rms (deviation). A third of the cases hide nothing. Of
the rest some hide forms that the library lacks, and some what is in no library.
"""

from dataclasses import dataclass

import numpy as np

from tests.simulators.hidden_mechanisms import excitation, sensed, simulate, simulate_two, torque_for

PERIODS = 30  # of the mechanism's own frequency in a recording
KINDS = ("random", "multisine", "chirp", "decay", "steps", "road")
SETTINGS = ("driven", "imposed", "two_mass", "closed_loop", "mass_spring_damper")
FAMILY = {"friction": "coulomb_friction", "hardening": "hardening_stiffness", "backlash": "backlash", "drag": "progressive_damping",
          "hysteresis": "hysteresis", "asymmetry": "asymmetry", "drift": "drift", "sine": "geometric_nonlinearity", "saturation": "saturation",
          "delay": "channel_delay", "extra": "extra_mode", "clip": "saturation", "sensor": "sensor_nonlinearity"}  # fmt: skip
UNLIKE = {"smooth_friction": "coulomb_friction", "sinh_hardening": "hardening_stiffness", "blunt_drag": "progressive_damping",
          "atan_backlash": "backlash", "thin_loop": "hysteresis"}  # fmt: skip
OUTSIDE = ("ripple", "pulse")
HIDDEN = (*FAMILY, *UNLIKE, *OUTSIDE)
ELSEWHERE = {"sine": ("driven", "imposed"), "clip": ("driven", "two_mass", "closed_loop", "mass_spring_damper"),
             "delay": ("driven", "imposed", "mass_spring_damper"), "extra": ("driven", "imposed", "closed_loop", "mass_spring_damper")}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """The truth (`hidden` is "none" where nothing is) and what was recorded: arrays by name; `near` are values to start from."""

    number: int
    hidden: str
    setting: str
    kind: str
    noise: float
    time: np.ndarray
    columns: dict[str, np.ndarray]
    near: dict[str, float]


def sizes(rng: np.random.Generator, joint: dict[str, float], angle: float, torque: float) -> dict:
    """The size of everything, so that it is seen but does not rule: angle and torque are the joint's without it."""
    frequency = np.sqrt(joint["k"] / joint["J"]) / (2 * np.pi)
    rate = angle * 2 * np.pi * frequency
    u = rng.uniform(0.5, 1.5)
    drag = u * (0.5 * joint["c"] / rate + 0.05 * joint["k"] * angle / rate**2)
    return {"friction": 0.2 * u * torque, "hardening": 0.4 * u * joint["k"] / angle**2, "backlash": 0.08 * u * angle, "drag": drag,
            "hysteresis": (0.25 * u * torque, 0.1 * angle), "asymmetry": 0.1 * u, "drift": 0.15 * u, "sine": 1.0, "saturation": 0.5 * u * angle,
            "delay": 0.03 * u / frequency, "extra": (0.1 * u * joint["J"], frequency * rng.uniform(0.6, 2.5), 0.1), "clip": torque * (0.7 + 0.5 * u),
            "sensor": 0.15 * u, "smooth_friction": (0.2 * u * torque, 0.05 * rate), "sinh_hardening": (0.04 * u * joint["k"] * angle, angle / 3),
            "blunt_drag": drag * np.sqrt(rate), "atan_backlash": 0.08 * u * angle, "thin_loop": (0.25 * u * torque, 0.1 * angle),
            "ripple": (0.25 * u * torque, angle / 4), "pulse": (0.15 * u, 0.7 * frequency)}  # fmt: skip


def draw(number: int) -> Case:
    """The case of that number."""
    rng = np.random.default_rng(number)
    name = "none" if number % 3 == 0 else HIDDEN[(number - number // 3 - 1) % len(HIDDEN)]
    setting = SETTINGS[int(rng.integers(len(SETTINGS)))]
    if setting not in ELSEWHERE.get(name, SETTINGS):
        setting = ELSEWHERE[name][int(rng.integers(len(ELSEWHERE[name])))]
    kinds = [k for k in KINDS if k != "decay" or (setting == "driven" and name not in ("clip", "delay"))]
    kinds = [
        k for k in kinds if k not in ("steps", "road") or setting != "imposed"
    ]  # no servo imposes a jump of the acceleration
    kind, noise = kinds[int(rng.integers(len(kinds)))], 0.002 * 15 ** rng.uniform()
    large = setting == "mass_spring_damper"  # hundreds of kilogrammes, kilonewtons, millimetres
    joint = {
        "J": (300.0 if large else 0.1) * np.exp(rng.normal()),
        "k": (1e6 if large else 10.0) * np.exp(rng.normal()),
    }
    joint["c"] = 2 * np.sqrt(joint["J"] * joint["k"]) * rng.uniform(0.03, 0.2)
    joint |= {"J2": joint["J"] * np.exp(0.5 * rng.normal()), "c1": 0.2 * joint["c"], "c2": 0.3 * joint["c"]}
    angle = 1.2 if name == "sine" else (0.005 if large else 1.0) * float(np.exp(rng.uniform(-3, 0)))
    frequency = np.sqrt(joint["k"] / joint["J"]) / (2 * np.pi)
    joint["sliding"] = 1e-3 * angle * 2 * np.pi * frequency
    time = np.arange(0, PERIODS / frequency * (0.4 if kind == "decay" else 1.0), 1 / (frequency * rng.uniform(40, 90)))
    columns = _recorded(rng, name, setting, kind, joint, angle, frequency, time)
    of_twist = 0.4 * angle if setting == "two_mass" else None  # both turn far, which makes no encoder worse
    shown = {
        n: y + noise * (of_twist or y.std()) * rng.standard_normal(len(y)) if n in _measured(setting) else y
        for n, y in columns.items()
    }
    zeros = np.random.default_rng([number, 1])
    shown = {n: y + zeros.normal(0, 0.3 if n in _measured(setting) else 0.1) * y.std() for n, y in shown.items()}
    if setting == "imposed":
        shown["angle"] = shown["angle"] + 1e-4 * angle * rng.standard_normal(len(time))
    near = {n: joint[n] * float(np.exp(0.5 * rng.normal())) for n in ("J", "J2", "k", "c", "c1", "c2")}
    return Case(number, name, setting, kind, noise, time, shown, near)


def _measured(setting: str) -> tuple[str, ...]:
    return {"imposed": ("torque",), "two_mass": ("angle", "load_angle"), "mass_spring_damper": ("displacement",)}.get(
        setting, ("angle",)
    )


def _recorded(rng, name, setting, kind, joint, angle, frequency, time) -> dict[str, np.ndarray]:
    """Torque and motion without noise."""
    unit = excitation(kind, rng, time[-1], 2.5 * frequency, 1.0)
    if setting == "imposed":
        motion = _times(angle / np.abs(unit(time)).max(), unit)
        hidden = _chosen(rng, name, joint, angle, float(torque_for(joint, {}, motion, time).std()))
        return {"torque": sensed(hidden, torque_for(joint, hidden, motion, time)), "angle": motion(time)}
    if setting == "two_mass":
        unit = unit.derivative()  # without a mean, which would turn both away for good
        motion = simulate_two(joint, {}, unit, time)[0]
        factor = angle / np.abs(motion[:, 0] - motion[:, 1]).max()
        hidden = _chosen(rng, name, joint, angle, factor)
        motion, torque = simulate_two(joint, hidden, _times(factor, unit), time)
        return {"torque": torque, "angle": sensed(hidden, motion[:, 0]), "load_angle": motion[:, 1]}
    if setting == "closed_loop":
        stiff, slow = 2 * joint["k"], 0.3 * np.sqrt(joint["k"] * joint["J"])

        def feedback(wanted):
            return lambda t, q, s: stiff * (wanted(t) - q) - slow * s

        motion, torque = simulate(joint, {}, None, time, feedback=feedback(unit))
        factor = angle / np.abs(motion[:, 0]).max()
        hidden = _chosen(rng, name, joint, angle, factor * torque.std())
        motion, torque = simulate(joint, hidden, None, time, feedback=feedback(_times(factor, unit)))
        return {"torque": torque, "angle": sensed(hidden, motion[:, 0])}
    if kind == "decay":
        hidden = _chosen(rng, name, joint, angle, 0.1 * joint["k"] * angle)
        motion, _ = simulate(joint, hidden, unit, time, (angle, 0.0))
        return {"angle": sensed(hidden, motion[:, 0])}
    factor = angle / np.abs(simulate(joint, {}, unit, time)[0][:, 0]).max()
    hidden = _chosen(rng, name, joint, angle, factor)
    motion, torque = simulate(joint, hidden, _times(factor, unit), time)
    names = ("force", "displacement") if setting == "mass_spring_damper" else ("torque", "angle")
    return dict(zip(names, (torque, sensed(hidden, motion[:, 0])), strict=True))


def _chosen(rng, name, joint, angle, torque) -> dict:
    return {} if name == "none" else {name: sizes(rng, joint, angle, torque)[name]}


def _times(factor, function):
    """A function of time, and its derivatives, times a factor."""
    return lambda t, *order: factor * function(t, *order)
