"""Blind cases on whole vehicles of which only some channels are recorded, all drawn by number; half of them hide nothing.

A motorcycle whose values are known to 1 and 5 %, or a bicycle whose matrices are known to 3 %, at one speed or several,
held by a rider who steers into the fall, shaken at the handlebar, kicked, or left to wind and road; different channels
are logged, with different noise.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from tests.simulators import hidden_bicycle, hidden_ride
from tests.simulators.hidden_vehicle import SHARP, known_to

FAMILY = {"friction": "coulomb_friction", "motor": "channel_delay", "late": "channel_delay", "motor_gain": "motor_gain", "damper": "steer_damping",
          "spring": "steer_stiffness", "steer_inertia": "added_inertia", "roll_inertia": "roll_inertia", "twist": "frame_compliance", "lean": "rider_lean",
          "relaxation": "tyre_relaxation", "air_load": "aerodynamics"}  # fmt: skip
OUTSIDE = ("controller", "rear_tyre", "yaw_inertia")
ON_BICYCLES = {"friction": (0.2, 0.6), "damping": (0.8, 3.0), "delay": (3, 8)}  # N.m, N.m.s/rad, samples
BICYCLES = {"friction": "coulomb_friction", "damping": "steer_damping", "delay": "channel_delay"}
CHANNELS = (("steer_angle", "roll_rate", "yaw_rate"), ("steer_angle", "roll_rate"), ("roll_rate", "yaw_rate"),
            ("steer_angle", "steer_rate", "roll_rate", "roll_angle"), ("steer_angle", "yaw_rate"))  # fmt: skip
KINDS = ("shaken", "kicked", "shaken", "ridden")
FALLEN = 0.6  # rad


@dataclass(frozen=True)
class Case:
    """The truth ("none" where nothing is hidden, its family "" where no library has it), what is known, and the recordings' files."""

    number: int
    hidden: str
    family: str
    size: Any
    vehicle: str
    kind: str
    known: dict[str, float] = field(repr=False)
    speeds: tuple[float, ...]
    channels: tuple[str, ...]
    files: tuple[str, ...]


def sizes(rng: np.random.Generator) -> dict[str, dict]:
    """What is hidden in a motorcycle, of a size that is felt."""
    return {
        "friction": {"friction": rng.uniform(0.5, 2.0)}, "motor": {"motor": int(rng.integers(2, 7))}, "late": {"late": int(rng.integers(3, 8))},
        "motor_gain": {"motor_gain": rng.choice([0.75, 1.3])}, "damper": {"damper": rng.uniform(3, 9)}, "spring": {"spring": rng.uniform(20, 80)},
        "steer_inertia": {"steer_inertia": rng.uniform(0.1, 0.4)}, "roll_inertia": {"roll_inertia": rng.uniform(10, 40)},
        "twist": {"compliance": 10 ** rng.uniform(-5, -4.2), "axis": rng.uniform(0.2, 0.6)},
        "lean": {"lean": (rng.uniform(20, 50), rng.uniform(1, 4), rng.uniform(0.1, 0.5))},
        "relaxation": dict.fromkeys(("sigma_f", "sigma_r"), rng.uniform(0.1, 0.3)), "air_load": {"air_load": rng.uniform(0.08, 0.2)},
        "controller": {"controller": rng.uniform(10, 30) * rng.choice([-1, 1])}, "rear_tyre": {"rear_tyre": rng.choice([0.6, 1.6])},
        "yaw_inertia": {"yaw_inertia": rng.uniform(8, 20)},
    }  # fmt: skip


def draw(number: int, folder: Path, duration: float = 60.0) -> Case:
    """The case of that number, its recordings written into the folder."""
    rng = np.random.default_rng(900_000 + number)
    if rng.random() < 0.25:
        return _bicycle(number, rng, folder, duration)
    name = "none" if number % 2 == 0 else [*FAMILY, *OUTSIDE][(number // 2) % (len(FAMILY) + len(OUTSIDE))]
    kind, channels = KINDS[rng.integers(len(KINDS))], CHANNELS[rng.integers(len(CHANNELS))]
    excitation = {
        "shaken": {"shaken": rng.uniform(0.5, 2)},
        "kicked": {"shaken": 0.0, "kicked": rng.uniform(8, 20)},
        "ridden": {"shaken": rng.uniform(0.1, 0.4)},
    }[kind]
    pushed = rng.uniform(0.3, 2)
    while True:  # until nobody falls
        known = known_to(rng, SHARP, 3.0)
        real = known_to(rng, known)
        hidden, late = sizes(rng)[name] if name != "none" else {}, {}
        if name == "late":
            hidden, late = {}, {channels[rng.integers(len(channels))]: hidden["late"]}
        first = rng.uniform(8, 40)
        speed = (first, first * rng.uniform(1.1, 1.3)) if rng.random() < 0.25 else first
        gain = float(rng.uniform(0.5, 2)) * np.array([-10.0, -5.0])
        ridden = hidden_ride.ride(rng, real, speed, hidden, duration, pushed, gain=tuple(gain), **excitation)
        if max(np.abs(ridden[n]).max() for n in ("phi", "delta")) < FALLEN:
            break
    logged = rng.random() < 0.85 or name in ("motor", "motor_gain")
    file = hidden_ride.write_ride(
        folder / f"case_{number}.csv", ridden, rng, channels, logged, late, rng.uniform(0.5, 2)
    )
    return Case(
        number,
        name,
        FAMILY.get(name, ""),
        hidden or late,
        "motorcycle",
        kind,
        known,
        tuple(np.ravel(speed)),
        channels + ("steer_torque",) * logged,
        (file,),
    )


def _bicycle(number: int, rng: np.random.Generator, folder: Path, duration: float) -> Case:
    name = "none" if number % 2 == 0 else list(ON_BICYCLES)[number // 2 % len(ON_BICYCLES)]
    while True:  # until nobody falls
        hidden = (
            {name: rng.uniform(*ON_BICYCLES[name]) if name != "delay" else int(rng.integers(*ON_BICYCLES[name]))}
            if name != "none"
            else {}
        )
        model = hidden_bicycle.bicycle(rng, 0.03)
        slowest = rng.uniform(3.8, 5.0)
        speeds = (slowest, slowest * rng.uniform(1.0, 1.4))
        ridden = hidden_bicycle.ride(
            rng, model, duration, pushed=rng.uniform(0.3, 1.5), shaken=rng.uniform(0.5, 2), speeds=speeds, **hidden
        )
        if np.abs(ridden[:, [2, 4]]).max() < FALLEN:
            break
    columns = list(hidden_bicycle.COLUMNS)
    kept = [0, 1, *sorted(1 + rng.choice([1, 2, 3, 4], size=rng.integers(2, 4), replace=False)), 6]
    header = ",".join("time [s]" if i == 0 else columns[i - 1] for i in kept)
    file = folder / f"case_{number}.csv"
    np.savetxt(file, ridden[:, kept], delimiter=",", header=header, comments="", fmt="%.8g")
    return Case(
        number,
        name,
        BICYCLES.get(name, ""),
        hidden,
        "bicycle",
        "shaken",
        {},
        speeds,
        tuple(columns[i - 1].split()[0] for i in kept[2:]),
        (str(file),),
    )
