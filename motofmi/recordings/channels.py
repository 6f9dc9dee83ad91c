"""The channels of the test rigs: one table of names, units, descriptions and aliases in files."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from math import inf, pi

from fmus.declaration.units import BASE, unit

TIME = "time"
STEER_ANGLE, STEER_ANGLE_COMMAND, STEER_TORQUE = "steer_angle", "steer_angle_command", "steer_torque"
STEER_RATE, TORSO_RATE = "steer_rate", "torso_rate"
ROLL_ANGLE, MOCKUP_ACCELERATION = "roll_angle", "mockup_acceleration"
BODY_POINTS = ("waist", "shoulder", "head")  # of the roll test, from the seat up


@dataclass(frozen=True)
class Channel:
    """What a rig measures: name, SI unit, meaning, and aliases in lower case with underscores.

    Larger values than `largest` [unit] indicate a wrong unit or swapped channels. Without an `essential` channel there
    is no test: if it is constant, its sensor is not connected.
    """

    name: str
    unit: str
    meaning: str
    aliases: tuple[str, ...] = ()
    largest: float = inf
    essential: bool = False


CHANNELS = {channel.name: channel for channel in (
    Channel(TIME, "s", "Time of the sample", ("t", "timestamp", "time_stamp", "elapsed_time")),
    Channel(STEER_ANGLE, "rad", "Angle of the handlebar relative to the rear "
                                "frame", ("steering_angle", "handlebar_angle"), pi / 2, True),
    Channel(STEER_ANGLE_COMMAND, "rad", "Steer angle that the servo is commanded",
            ("steering_angle_command", "commanded_steer_angle")),
    Channel(STEER_TORQUE, "N.m", "Torque of the servo on the handlebar", ("steering_torque",), 2000.0, True),
    Channel(STEER_RATE, "rad/s", "Rate of the steer angle", ("steering_rate",)),
    Channel(TORSO_RATE, "rad/s", "Yaw rate of the rider's torso, from a gyro on the back", (), 30.0),
    Channel(ROLL_ANGLE, "rad", "Roll angle of the mock-up", ("lean_angle",)),
    Channel(MOCKUP_ACCELERATION, "m/s2", "Tangential acceleration of the mock-up at its height above the roll axis"),
    *(Channel(f"{point}_acceleration", "m/s2", "Tangential acceleration of the rider's "
                                               f"{point}") for point in BODY_POINTS),
)}  # fmt: skip
UNITS = {name: channel.unit for name, channel in CHANNELS.items()}
FURTHER_UNITS = ("N", "kg.m2", "Hz", "m", "kg", "m/s", "V", "1")  # names that are preferred to products of base units


def units_of(names: Iterable[str]) -> dict[str, str]:
    """The SI units of channels by name, without the time's, as a recording has them."""
    return {name: UNITS[name] for name in names if name != TIME}


def channel_name(column: str, expected: Iterable[str]) -> str:
    """The expected name of a column: its own, the same in other letters ("Steer Angle"), or that of the channel of
    which it is an alias; else its own."""
    expected = set(expected)
    if column in expected:
        return column
    plain, of_letters = _plain(column), {_plain(name): name for name in sorted(expected)}
    alias = next((c.name for c in CHANNELS.values() if c.name in expected and plain in c.aliases), column)
    return of_letters.get(plain, alias)


def _plain(name: str) -> str:
    """A name in lower case, with underscores between its words."""
    return re.sub(r"[\s.-]+", "_", name.strip()).lower()


def si_unit(name: str) -> str:
    """The name of the SI unit that measures the same as the given one: rad for deg, N.m for mNm. Raises InputError
    for an unknown one."""
    given = unit(name)
    by_exponents = {unit(known).exponents: known for known in (*UNITS.values(), *FURTHER_UNITS)}
    if given.factor == 1.0 and name.isascii():
        return name
    if given.exponents in by_exponents:
        return by_exponents[given.exponents]
    return ".".join(f"{base}{power}" for base, power in zip(BASE, given.exponents, strict=True) if power)
