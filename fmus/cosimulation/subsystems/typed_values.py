"""Values of variables by their type: a number, a Boolean, a text or an item of an enumeration."""

from collections.abc import Mapping

from fmpy.model_description import ModelVariable

from fmus.support.errors import InputError, unknown

Value = float | int | bool | str
REAL = ("Real", "Float64")  # the types whose values are read and set in every step
TRUTH: Mapping[str, bool] = {"true": True, "1": True, "false": False, "0": False}


def typed(variable: ModelVariable, value: Value) -> Value:
    """The value as the variable's type has it. Raises InputError with the variable's name where it does not fit."""
    kind = variable.type
    try:
        if kind in (*REAL, "Float32"):
            return float(value)
        if kind == "Boolean":
            return TRUTH[str(value).lower().removesuffix(".0")]
        if kind == "Enumeration" and isinstance(value, str):
            return _item(variable, value)
        if kind == "String":
            return str(value)
        if float(value) == int(float(value)):
            return int(value) if isinstance(value, int) else int(float(value))
    except (ValueError, KeyError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
    raise InputError(f"{variable.name} = {value!r} does not fit a variable of type {kind}")


def _item(variable: ModelVariable, text: str) -> int:
    items = {item.name: int(item.value) for item in getattr(variable.declaredType, "items", None) or ()}
    if text not in items and not text.lstrip("+-").isdigit():
        raise unknown(f"item of {variable.name}", text, items)
    return items[text] if text in items else int(text)
