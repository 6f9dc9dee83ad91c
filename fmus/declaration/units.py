"""Units: SI inside, in every table and file; other units only at the edge, converted on the way in.

A unit is written as in Modelica without parentheses: `N.m.s/rad`, `kg.m2`, `1`. Everything after the
slash is a denominator. Each unit is its factor to SI and its exponents of the SI base units, which is
also what an FMI model description needs.
"""

import re
from dataclasses import dataclass
from functools import cache
from math import pi

from fmus.errors import InputError

BASE = ("kg", "m", "s", "A", "K", "rad")

# symbol: (factor to SI, exponents of BASE)
SYMBOLS = {
    "kg": (1.0, (1, 0, 0, 0, 0, 0)),
    "g": (1e-3, (1, 0, 0, 0, 0, 0)),
    "m": (1.0, (0, 1, 0, 0, 0, 0)),
    "mm": (1e-3, (0, 1, 0, 0, 0, 0)),
    "km": (1e3, (0, 1, 0, 0, 0, 0)),
    "s": (1.0, (0, 0, 1, 0, 0, 0)),
    "ms": (1e-3, (0, 0, 1, 0, 0, 0)),
    "h": (3600.0, (0, 0, 1, 0, 0, 0)),
    "A": (1.0, (0, 0, 0, 1, 0, 0)),
    "K": (1.0, (0, 0, 0, 0, 1, 0)),
    "rad": (1.0, (0, 0, 0, 0, 0, 1)),
    "deg": (pi / 180, (0, 0, 0, 0, 0, 1)),
    "N": (1.0, (1, 1, -2, 0, 0, 0)),
    "kN": (1e3, (1, 1, -2, 0, 0, 0)),
    "Nm": (1.0, (1, 2, -2, 0, 0, 0)),
    "mNm": (1e-3, (1, 2, -2, 0, 0, 0)),
    "J": (1.0, (1, 2, -2, 0, 0, 0)),
    "W": (1.0, (1, 2, -3, 0, 0, 0)),
    "Hz": (1.0, (0, 0, -1, 0, 0, 0)),
    "rpm": (2 * pi / 60, (0, 0, -1, 0, 0, 1)),
    "V": (1.0, (1, 2, -3, -1, 0, 0)),
    "mV": (1e-3, (1, 2, -3, -1, 0, 0)),
    "1": (1.0, (0, 0, 0, 0, 0, 0)),
    "%": (1e-2, (0, 0, 0, 0, 0, 0)),
}

# What a person would rather read on a screen or in a simulator's dialogue.
DISPLAY = {
    "rad": "deg",
    "rad/s": "deg/s",
    "m/s": "km/h",
    "N.m/rad": "N.m/deg",
    "N.m.s/rad": "N.m.s/deg",
}


@dataclass(frozen=True)
class Unit:
    """A unit: its name, its factor to SI and its exponents of kg, m, s, A, K, rad."""

    name: str
    factor: float
    exponents: tuple[int, ...]

    def to(self, other: "Unit") -> float:
        """The factor that turns a number in this unit into one in the other.

        Raises InputError when the two do not measure the same thing.
        """
        if self.exponents != other.exponents:
            raise InputError(f"unit [{self.name}] cannot be converted to [{other.name}]: they measure different things")
        return self.factor / other.factor


@cache
def unit(name: str) -> Unit:
    """The unit of that name. Raises InputError for a symbol that is not known."""
    factor, exponents = 1.0, [0] * len(BASE)
    for part, side in enumerate(name.replace(" ", "").split("/")):
        for token in re.split(r"[.*]", side):
            match = re.fullmatch(r"(1|%|[A-Za-z]+)(?:\^?(-?\d+))?", token)
            if match is None or match[1] not in SYMBOLS:
                raise InputError(f"unknown unit [{name}] at {token!r} (known symbols: {' '.join(sorted(SYMBOLS))})")
            power = int(match[2] or 1) * (-1 if part else 1)
            scale, powers = SYMBOLS[match[1]]
            factor *= scale**power
            exponents = [e + power * p for e, p in zip(exponents, powers, strict=True)]
    return Unit(name, factor, tuple(exponents))


def convert(value: float, given: str, wanted: str) -> float:
    """`value` in the unit `given`, as a number in the unit `wanted`."""
    return value * unit(given).to(unit(wanted))
