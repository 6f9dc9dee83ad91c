"""Values along one axis: a range A:B:STEP or A:B:N, a list, one value, or any array.

values_of("trail", "0.08:0.12:9")      # nine values from 0.08 to 0.12, both included
"""

from collections.abc import Sequence
from numbers import Real
from typing import Any

import numpy as np

from fmus.support.errors import InputError

MOST = 1_000_000  # values along one axis; more are taken for a typing error and refused


def values_of(name: str, given: Any) -> np.ndarray:
    """The values (n,) that a text, a number or a sequence gives. Raises InputError for anything else."""
    expected = f"{name} = {given!r} is not A:B:N (N values from A to B), a list of numbers or one number"
    if isinstance(given, str):
        return _from_text(name, given, expected)
    if isinstance(given, Real):
        given = [given]
    if not isinstance(given, Sequence | np.ndarray) or not len(given):
        raise InputError(expected)
    try:
        values = np.asarray(given, float)
    except (TypeError, ValueError):
        raise InputError(expected) from None
    return _checked(name, values, expected)


def _from_text(name: str, text: str, expected: str) -> np.ndarray:
    parts = text.split(":" if ":" in text else ",")
    try:
        numbers = [float(part) for part in parts]
    except ValueError:
        raise InputError(expected) from None
    if ":" not in text:
        return _checked(name, np.array(numbers), expected)
    if len(numbers) != 3 or not numbers[2].is_integer() or numbers[2] < 1:
        raise InputError(f"{expected}; the third number is the number of values, as in {parts[0]}:{parts[1]}:9")
    if numbers[2] > MOST:
        raise InputError(f"{name} = {text!r} has more than {MOST:,} values")
    return _checked(name, np.linspace(numbers[0], numbers[1], int(numbers[2])), expected)


def _checked(name: str, values: np.ndarray, expected: str) -> np.ndarray:
    if values.ndim != 1 or not np.isfinite(values).all():
        raise InputError(f"{expected}; every value must be finite")
    if len(np.unique(values)) < len(values):
        raise InputError(f"{name} has the same value twice")
    return values


def numbers(text: str, what: str, unit: str, above: float = 0.0, zero: bool = False) -> np.ndarray:
    """The values (n,) of `A:B:STEP` (both ends included), of one value, or of a comma list, in the given unit.

    Raises InputError for text of another form, and for values that are not ascending and `above` that number, or with
    `zero` that number itself.
    """
    kind = "ascending numbers" if above else "ascending numbers from 0 on" if zero else "positive ascending numbers"
    expected = f"{what} {text!r} is not A:B:STEP, one value or a comma list of {kind} [{unit}], as in 1:60:0.5"
    try:
        given = [float(part) for part in text.split(":" if ":" in text else ",")]
    except ValueError:
        raise InputError(expected) from None
    values = np.array(given)
    if ":" in text:
        if not (len(given) == 3 and np.isfinite(given).all() and given[2] > 0 and given[1] >= given[0]):
            raise InputError(expected)
        first, last, step = given
        if (last - first) / step > MOST:
            raise InputError(f"{what} {text!r} has more than {MOST:,} values; give a larger step")
        values = first + step * np.arange(int((last - first) / step + 1e-9) + 1)
        values = np.append(values, last) if values[-1] < last - 1e-9 * step else values
    if not (np.isfinite(values).all() and (values >= above if zero else values > above).all() and (np.diff(values) > 0).all()):
        raise InputError(expected)
    return values
