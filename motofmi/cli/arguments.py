"""What the words of a command line mean: `A:B:STEP`, `NAME=VALUE`, comma lists."""

from collections.abc import Iterable, Sequence

import numpy as np

from fmus.support.errors import InputError

MOST = 1e6  # values in one range: a range with more of them is a typing error


def numbers(text: str, what: str, unit: str) -> np.ndarray:
    """`A:B:STEP` with both ends, one value, or a comma list, as ascending positive numbers.

    Raises InputError that says what was expected.
    """
    form = f"{what} {text!r} is not A:B:STEP, one value or a comma list of positive ascending numbers [{unit}], as in 1:60:0.5"
    try:
        given = [float(part) for part in text.split(":" if ":" in text else ",")]
    except ValueError:
        raise InputError(form) from None
    values = np.array(given)
    if ":" in text:
        if not (len(given) == 3 and np.isfinite(given).all() and given[2] > 0 and given[1] >= given[0]):
            raise InputError(form)
        first, last, step = given
        if (last - first) / step > MOST:
            raise InputError(f"{what} {text!r} has more than {MOST:g} values; take a larger step")
        values = first + step * np.arange(int((last - first) / step + 1e-9) + 1)
        values = np.append(values, last) if values[-1] < last - 1e-9 * step else values
    if not (np.isfinite(values).all() and (values > 0).all() and (np.diff(values) > 0).all()):
        raise InputError(form)
    return values


def separate(text: str) -> list[str]:
    """The parts of a comma list."""
    return [part.strip() for part in text.split(",")]


def assignments(texts: Iterable[str]) -> dict[str, float]:
    """`NAME=VALUE` texts as a dictionary. Raises InputError for what is not one."""
    values = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            values[name.strip()] = float(value)
        except ValueError:
            equals = ""
        if equals == "" and set(value) & set(":,~") and name.strip():
            raise InputError(f"{text!r} gives several values, and a command runs with one: repeat it in a loop, as in "
                             f"for x in 10 20 30; do motofmi modes --set {name.strip()}=$x --json modes_$x.json; "
                             "done")  # fmt: skip
        if not equals:
            raise InputError(f"{text!r} is not NAME=VALUE with a number, as in arm_damping=20")
    return values


def mapping_of(texts: Sequence[str]) -> dict[str, str]:
    """Variables by column, of texts COLUMN=VARIABLE. Raises InputError for a text that is none."""
    mapping = {}
    for text in texts:
        column, equals, variable = text.partition("=")
        if not (equals and column.strip() and variable.strip()):
            raise InputError(f'--map {text!r} is not COLUMN=VARIABLE, as in "Torque=steer_torque [N.m]"')
        mapping[column.strip()] = variable.strip()
    return mapping
