"""Values in the text of command-line options: ranges `A:B:STEP`, assignments `NAME=VALUE`, comma lists."""

from collections.abc import Iterable, Sequence
from typing import TypeVar

from fmus.support.errors import InputError
from motofmi.studies.axes import numbers

__all__ = ["assignments", "mapping_of", "numbers", "separate"]

T = TypeVar("T")


def separate(text: str) -> list[str]:
    """The parts of a comma list, without surrounding blanks."""
    return [part.strip() for part in text.split(",")]


def _entered(values: dict[str, T], name: str, value: T) -> None:
    """Enter a value under a name. Raises InputError where the name has another one."""
    if name in values and values[name] != value:
        raise InputError(f"{name} is given twice, {values[name]} and {value}: give each name one value")
    values[name] = value


def assignments(texts: Iterable[str]) -> dict[str, float]:
    """Values by name, from texts NAME=VALUE. Raises InputError for a text of another form."""
    values: dict[str, float] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            number = float(value)
        except ValueError:
            equals = ""
        if equals == "" and set(value) & set(":,~") and name.strip():
            raise InputError(f"{text!r} gives several values, but a command takes one value: repeat the command in a "
                             f"loop, as in for x in 10 20 30; do motofmi modes --set {name.strip()}=$x --json "
                             "modes_$x.json; done")  # fmt: skip
        if not equals:
            raise InputError(f"{text!r} is not NAME=VALUE with a number, as in arm_damping=20")
        _entered(values, name.strip(), number)
    return values


def values_of(texts: Iterable[str]) -> dict[str, float | str]:
    """Numbers or texts by name, from texts NAME=VALUE; Booleans are `true` and `false`. Raises InputError for a text of
    another form."""
    found: dict[str, float | str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not (equals and name.strip()):
            raise InputError(f"{text!r} is not NAME=VALUE, as in arm_damping=20")
        _entered(found, name.strip(), _number_or_text(value))
    return found


def _number_or_text(value: str) -> float | str:
    try:
        return float(value)
    except ValueError:
        return value


def units_of(texts: Iterable[str]) -> dict[str, str]:
    """Units by variable, from texts VARIABLE=UNIT. Raises InputError for a text of another form."""
    found: dict[str, str] = {}
    for text in texts:
        variable, equals, unit = text.partition("=")
        if not (equals and variable.strip() and unit.strip()):
            raise InputError(f"--unit {text!r} is not VARIABLE=UNIT, as in handlebar_torque=N.m")
        _entered(found, variable.strip(), unit.strip().removeprefix("[").removesuffix("]"))
    return found


def mapping_of(texts: Sequence[str]) -> dict[str, str]:
    """Variable names by column name, from texts COLUMN=VARIABLE. Raises InputError for a text of another form."""
    mapping: dict[str, str] = {}
    for text in texts:
        column, equals, variable = text.partition("=")
        if not (equals and column.strip() and variable.strip()):
            raise InputError(f'--map {text!r} is not COLUMN=VARIABLE, as in "Torque=steer_torque [N.m]"')
        _entered(mapping, column.strip(), variable.strip())
    return mapping
