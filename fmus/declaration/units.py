"""Units of measurement. All values are SI internally; other units are converted when data are read.

A unit is written as in Modelica, without parentheses: `N.m.s/rad`, `kg.m2`, `1`. Everything after the slash is the
denominator. A unit is defined by its factor to SI and its exponents of the SI base units, which are also the entries of
an FMI model description. Recordings may also have the notation of laboratories: `N·m`, `N-m`, `m/s²`, `°/s`, `RPM`,
`degrees`.

Factors of the foot, inch, pound and pound-force: NIST Special Publication 811 (2008), Appendix B.8.
"""

import re
from dataclasses import dataclass
from functools import cache
from math import pi

from fmus.support.errors import InputError

POUND, GRAVITY = 0.45359237, 9.80665  # kg and m/s2, both exact by definition
PARENTHESES = "a unit has no parentheses: all after the slash is the denominator, as in 1/V.s; "
BASE = ("kg", "m", "s", "A", "K", "rad")

# symbol: (factor to SI, exponents of BASE)
SYMBOLS = {
    "kg": (1.0, (1, 0, 0, 0, 0, 0)),
    "g": (1e-3, (1, 0, 0, 0, 0, 0)),
    "lb": (POUND, (1, 0, 0, 0, 0, 0)),
    "slug": (POUND * GRAVITY / 0.3048, (1, 0, 0, 0, 0, 0)),
    "m": (1.0, (0, 1, 0, 0, 0, 0)),
    "um": (1e-6, (0, 1, 0, 0, 0, 0)),
    "mm": (1e-3, (0, 1, 0, 0, 0, 0)),
    "cm": (1e-2, (0, 1, 0, 0, 0, 0)),
    "km": (1e3, (0, 1, 0, 0, 0, 0)),
    "ft": (0.3048, (0, 1, 0, 0, 0, 0)),
    "in": (0.0254, (0, 1, 0, 0, 0, 0)),
    "mi": (1609.344, (0, 1, 0, 0, 0, 0)),
    "s": (1.0, (0, 0, 1, 0, 0, 0)),
    "sec": (1.0, (0, 0, 1, 0, 0, 0)),
    "ms": (1e-3, (0, 0, 1, 0, 0, 0)),
    "us": (1e-6, (0, 0, 1, 0, 0, 0)),
    "min": (60.0, (0, 0, 1, 0, 0, 0)),
    "h": (3600.0, (0, 0, 1, 0, 0, 0)),
    "A": (1.0, (0, 0, 0, 1, 0, 0)),
    "mA": (1e-3, (0, 0, 0, 1, 0, 0)),
    "K": (1.0, (0, 0, 0, 0, 1, 0)),
    "rad": (1.0, (0, 0, 0, 0, 0, 1)),
    "mrad": (1e-3, (0, 0, 0, 0, 0, 1)),
    "deg": (pi / 180, (0, 0, 0, 0, 0, 1)),
    "°": (pi / 180, (0, 0, 0, 0, 0, 1)),
    "rev": (2 * pi, (0, 0, 0, 0, 0, 1)),
    "N": (1.0, (1, 1, -2, 0, 0, 0)),
    "mN": (1e-3, (1, 1, -2, 0, 0, 0)),
    "kN": (1e3, (1, 1, -2, 0, 0, 0)),
    "kgf": (GRAVITY, (1, 1, -2, 0, 0, 0)),
    "lbf": (POUND * GRAVITY, (1, 1, -2, 0, 0, 0)),
    "kip": (1e3 * POUND * GRAVITY, (1, 1, -2, 0, 0, 0)),
    "Nm": (1.0, (1, 2, -2, 0, 0, 0)),
    "mNm": (1e-3, (1, 2, -2, 0, 0, 0)),
    "Ncm": (1e-2, (1, 2, -2, 0, 0, 0)),
    "kNm": (1e3, (1, 2, -2, 0, 0, 0)),
    "J": (1.0, (1, 2, -2, 0, 0, 0)),
    "W": (1.0, (1, 2, -3, 0, 0, 0)),
    "gn": (GRAVITY, (0, 1, -2, 0, 0, 0)),
    "Pa": (1.0, (1, -1, -2, 0, 0, 0)),
    "kPa": (1e3, (1, -1, -2, 0, 0, 0)),
    "MPa": (1e6, (1, -1, -2, 0, 0, 0)),
    "bar": (1e5, (1, -1, -2, 0, 0, 0)),
    "psi": (POUND * GRAVITY / 0.0254**2, (1, -1, -2, 0, 0, 0)),
    "mph": (1609.344 / 3600, (0, 1, -1, 0, 0, 0)),
    "Hz": (1.0, (0, 0, -1, 0, 0, 0)),
    "kHz": (1e3, (0, 0, -1, 0, 0, 0)),
    "rpm": (2 * pi / 60, (0, 0, -1, 0, 0, 1)),
    "dps": (pi / 180, (0, 0, -1, 0, 0, 1)),
    "V": (1.0, (1, 2, -3, -1, 0, 0)),
    "mV": (1e-3, (1, 2, -3, -1, 0, 0)),
    "Ohm": (1.0, (1, 2, -3, -2, 0, 0)),
    "H": (1.0, (1, 2, -2, -2, 0, 0)),
    "mH": (1e-3, (1, 2, -2, -2, 0, 0)),
    "1": (1.0, (0, 0, 0, 0, 0, 0)),
    "%": (1e-2, (0, 0, 0, 0, 0, 0)),
}

# Words for symbols, and symbols in capitals, as recordings have them, in lower case. Case distinguishes prefixes
# (mPa, MPa), so that no other symbol is read without regard to it.
_WORDS = {
    "degree": "deg", "radian": "rad", "second": "s", "minute": "min", "metre": "m", "meter": "m", "newton": "N",
    "volt": "V", "amp": "A", "ampere": "A", "kilogram": "kg", "pascal": "Pa", "ohm": "Ohm",
}  # fmt: skip
SPELLINGS = {
    **{symbol: symbol for symbol in ("rpm", "deg", "rad", "rev", "sec", "mph", "psi", "dps", "bar")},
    **_WORDS, **{f"{word}s": symbol for word, symbol in _WORDS.items()}, "inch": "in", "inches": "in",
}  # fmt: skip

# Units with an offset, which no factor converts.
WITH_OFFSET = ("degC", "°C", "degF")

# Raised digits, and both characters for micro.
PLAIN = str.maketrans("⁻¹²³⁴µμ", "-1234uu")

# Units in which simulators display a variable (FMI's display units).
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

        Raises InputError when the dimensions differ.
        """
        if self.exponents != other.exponents:
            raise InputError(f"unit [{self.name}] cannot be converted to [{other.name}]: their dimensions differ")
        return self.factor / other.factor


@cache
def unit(name: str) -> Unit:
    """The unit of that name. Raises InputError for an unknown symbol.

        unit("N.m.s/rad").factor, unit("km/h").factor     # 1.0, 0.2777...
    """
    if name.strip() in WITH_OFFSET:
        raise InputError(f"the unit [{name}] has an offset, which is not converted: use K, in the "
                         "columns and in the component alike")  # fmt: skip
    factor, exponents = 1.0, [0] * len(BASE)
    written = re.sub(r"(?<=[\w°]) +(?=[A-Za-z°])", ".", name.strip()).replace(" ", "").translate(PLAIN)
    for part, side in enumerate(written.split("/")):
        for token in re.split(r"[.*·⋅]|-(?=[^\d])", side):
            match = re.fullmatch(r"(1|%|°|[A-Za-z]+)(?:\^?(-?\d+))?", token)
            symbol = match and (match[1] if match[1] in SYMBOLS else SPELLINGS.get(match[1].lower()))
            if match is None or symbol is None:
                raise InputError(
                    f"unknown unit [{name}] at {token!r} ({PARENTHESES if '(' in name else ''}"
                    f"known symbols: {' '.join(sorted(SYMBOLS))})"
                )
            power = int(match[2] or 1) * (-1 if part else 1)
            scale, powers = SYMBOLS[symbol]
            factor *= scale**power
            exponents = [e + power * p for e, p in zip(exponents, powers, strict=True)]
    return Unit(name, factor, tuple(exponents))


def written(value: str, name: str) -> str:
    """A number as text with its unit, which is left out where it is 1."""
    return value if name == "1" else f"{value} {name}"


def is_force(name: str) -> bool:
    """Whether a unit is one of force or of torque. Raises InputError for an unknown symbol."""
    return unit(name).exponents in (unit("N").exponents, unit("N.m").exponents)


def is_inertia(name: str) -> bool:
    """Whether a unit is one of mass or of a moment of inertia. Raises InputError for an unknown symbol."""
    return unit(name).exponents in (unit("kg").exponents, unit("kg.m2").exponents)


def is_stiffness(name: str) -> bool:
    """Whether a unit is one of stiffness, against a displacement or an angle. Raises InputError for an unknown symbol."""
    return unit(name).exponents in (unit("N/m").exponents, unit("N.m/rad").exponents)


def convert(value: float, given: str, wanted: str) -> float:
    """A value in the unit `given`, converted to the unit `wanted`. Raises InputError when the dimensions differ."""
    return value * unit(given).to(unit(wanted))
