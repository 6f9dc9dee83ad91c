"""Values in the text of command-line options: ranges `A:B:STEP`, assignments `NAME=VALUE`, comma lists."""

from collections.abc import Iterable, Sequence

import numpy as np

from fmus.support.errors import InputError

MAX_VALUES = 1e6  # in one range A:B:STEP; more values are taken for a typing error and refused


def numbers(text: str, what: str, unit: str) -> np.ndarray:
    """The values (n,) of `A:B:STEP` (both ends included), of one value, or of a comma list, in the given unit.

    Raises InputError for text of another form, and for values that are not positive and ascending.
    """
    expected = (f"{what} {text!r} is not A:B:STEP, one value or a comma list of positive ascending numbers [{unit}], "
                "as in 1:60:0.5")  # fmt: skip
    try:
        given = [float(part) for part in text.split(":" if ":" in text else ",")]
    except ValueError:
        raise InputError(expected) from None
    values = np.array(given)
    if ":" in text:
        if not (len(given) == 3 and np.isfinite(given).all() and given[2] > 0 and given[1] >= given[0]):
            raise InputError(expected)
        first, last, step = given
        if (last - first) / step > MAX_VALUES:
            raise InputError(f"{what} {text!r} has more than {MAX_VALUES:g} values; give a larger step")
        values = first + step * np.arange(int((last - first) / step + 1e-9) + 1)
        values = np.append(values, last) if values[-1] < last - 1e-9 * step else values
    if not (np.isfinite(values).all() and (values > 0).all() and (np.diff(values) > 0).all()):
        raise InputError(expected)
    return values


def separate(text: str) -> list[str]:
    """The parts of a comma list, without surrounding blanks."""
    return [part.strip() for part in text.split(",")]


def assignments(texts: Iterable[str]) -> dict[str, float]:
    """Values by name, from texts NAME=VALUE. Raises InputError for a text of another form."""
    values = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            values[name.strip()] = float(value)
        except ValueError:
            equals = ""
        if equals == "" and set(value) & set(":,~") and name.strip():
            raise InputError(f"{text!r} gives several values, but a command takes one value: repeat the command in a "
                             f"loop, as in for x in 10 20 30; do motofmi modes --set {name.strip()}=$x --json "
                             "modes_$x.json; done")  # fmt: skip
        if not equals:
            raise InputError(f"{text!r} is not NAME=VALUE with a number, as in arm_damping=20")
    return values


def values_of(texts: Iterable[str]) -> dict[str, float | str]:
    """Numbers or texts by name, from texts NAME=VALUE; Booleans are `true` and `false`. Raises InputError for a text of
    another form."""
    found: dict[str, float | str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not (equals and name.strip()):
            raise InputError(f"{text!r} is not NAME=VALUE, as in arm_damping=20")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            found[name.strip()] = value
    return found


def units_of(texts: Iterable[str]) -> dict[str, str]:
    """Units by variable, from texts VARIABLE=UNIT. Raises InputError for a text of another form."""
    found = {}
    for text in texts:
        variable, equals, unit = text.partition("=")
        if not (equals and variable.strip() and unit.strip()):
            raise InputError(f"--unit {text!r} is not VARIABLE=UNIT, as in handlebar_torque=N.m")
        found[variable.strip()] = unit.strip().removeprefix("[").removesuffix("]")
    return found


def mapping_of(texts: Sequence[str]) -> dict[str, str]:
    """Variable names by column name, from texts COLUMN=VARIABLE. Raises InputError for a text of another form."""
    mapping = {}
    for text in texts:
        column, equals, variable = text.partition("=")
        if not (equals and column.strip() and variable.strip()):
            raise InputError(f'--map {text!r} is not COLUMN=VARIABLE, as in "Torque=steer_torque [N.m]"')
        mapping[column.strip()] = variable.strip()
    return mapping
