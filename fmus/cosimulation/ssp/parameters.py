"""Values of parameter sets (.ssv), and what parameter mappings (.ssm) make of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from xml.etree import ElementTree as Xml

from fmpy.model_description import ModelVariable

from fmus.cosimulation.ssp.package import SSM, SSV, local, truth
from fmus.cosimulation.ssp.units import IDENTITY, Affine, UnitDefinition, conversion, defined_units, named_unit
from fmus.cosimulation.subsystems.typed_values import Value
from fmus.support.errors import InputError, unknown

REALS = ("Real", "Float64", "Float32")
INTEGERS = {"Integer", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64"}
MAPPED = {  # element of a mapping: the kinds that it is for
    "BooleanMappingTransformation": {"Boolean"},
    "IntegerMappingTransformation": {*INTEGERS, "Enumeration"},
    "EnumerationMappingTransformation": {"Enumeration"},
}


@dataclass(frozen=True)
class Setting:
    """A value for the variable `name`, as it is written: kind is the type, `array` for more than one value."""

    name: str
    kind: str
    text: str
    unit: UnitDefinition | None = None
    converts: bool = True  # to the unit of the variable, before `transformation`
    transformation: Affine = IDENTITY
    mapped: tuple[tuple[str, str], ...] = ()  # texts that are replaced

    def value(self, variable: ModelVariable, unit: UnitDefinition | None) -> Value:
        """The value for a variable of an FMU, in the unit of that variable.

        Raises InputError where the types do not fit and where the value cannot be converted.
        """
        if self.kind == "array" or variable.dimensions:
            raise InputError("arrays are not supported")
        text = dict(self.mapped).get(self.text, self.text)
        target = variable.type
        if target in REALS and (self.kind in REALS or self.kind in INTEGERS):
            linear = conversion(self.unit, unit) if self.converts else IDENTITY
            return linear.then(self.transformation)(_number(text, float))
        if target in INTEGERS and self.kind in INTEGERS:
            return _number(text, int)
        if target == "Boolean" and self.kind == "Boolean":
            return _boolean(text)
        if target == "String" and self.kind == "String":
            return text
        if target == "Enumeration" and self.kind in ("Enumeration", *INTEGERS):
            return _item(text, variable, self.kind)
        raise InputError(f"a value of type {self.kind} does not fit a variable of type {target}")


def _number(text: str, kind: Callable[[str], float | int]) -> float | int:
    try:
        return kind(text)
    except ValueError:
        raise InputError(f"{text!r} is no number") from None


def _boolean(text: str) -> bool:
    found = truth(text)
    if found is None:
        raise InputError(f"{text!r} is no Boolean (valid: true, false, 1, 0)")
    return found


def _item(text: str, variable: ModelVariable, kind: str) -> int:
    """The number of an enumeration's item, by its name or, where the value is an integer, by itself."""
    items = {item.name: int(item.value) for item in getattr(variable.declaredType, "items", None) or ()}
    if text in items:
        return items[text]
    if kind == "Enumeration" and items:
        raise unknown("item", text, items)
    return int(_number(text, int))


def settings_of(parameter_set: Xml.Element, units: Mapping[str, UnitDefinition], prefix: str) -> list[Setting]:
    """The values of a parameter set; units are those of the file around it."""
    known = {**units, **defined_units(parameter_set.iterfind(f"{{{SSV}}}Units"))}
    return [_setting(each, known, prefix) for each in parameter_set.iterfind(f"{{{SSV}}}Parameters/{{{SSV}}}Parameter")]


def _setting(parameter: Xml.Element, units: Mapping[str, UnitDefinition], prefix: str) -> Setting:
    name = prefix + parameter.get("name", "")
    values = [child for child in parameter if child.tag.startswith(f"{{{SSV}}}") and local(child.tag) != "Dimension"]
    dimensions = [child for child in parameter if local(child.tag) == "Dimension"]
    if not values:
        raise InputError(f"the parameter {name} has no value")
    value = values[0]
    entries = [child.get("value", "") for child in value if local(child.tag) == "Value"]
    if dimensions or len(entries) > 1:
        return Setting(name, "array", "")
    text = entries[0] if entries else value.get("value")
    if text is None:
        raise InputError(f"the parameter {name} has no value")
    return Setting(name, local(value.tag), text, named_unit(value.get("unit"), units))


def mapped(settings: list[Setting], mapping: Xml.Element) -> list[Setting]:
    """The settings that a parameter mapping names, under the names that it gives them; the others are left out."""
    known = {each.name: each for each in settings}
    return [
        _transformed(replace(known[entry.get("source", "")], name=entry.get("target", "")), entry)
        for entry in mapping.iterfind(f"{{{SSM}}}MappingEntry")
        if entry.get("source") in known
    ]


def _transformed(setting: Setting, entry: Xml.Element) -> Setting:
    setting = replace(setting, converts=setting.converts and not truth(entry.get("suppressUnitConversion")))
    for child in transformations(entry):
        kind = local(child.tag)
        if kind == "LinearTransformation":
            setting = replace(setting, transformation=linear(child))
        elif setting.kind in MAPPED.get(kind, ()):
            pairs = tuple((each.get("source", ""), each.get("target", "")) for each in child)
            setting = replace(setting, mapped=_of_truth(pairs) if setting.kind == "Boolean" else pairs)
        else:
            raise InputError(f"{kind} does not fit a value of type {setting.kind}")
    return setting


def _of_truth(pairs: tuple[tuple[str, str], ...]) -> tuple[tuple[str, str], ...]:
    """Pairs of Booleans in every spelling of their source."""
    spellings = {True: ("true", "1"), False: ("false", "0")}
    return tuple((text, target) for source, target in pairs for text in spellings[_boolean(source)])


def transformations(element: Xml.Element) -> list[Xml.Element]:
    """The transformations that an entry of a mapping or a connection has."""
    return [child for child in element if local(child.tag).endswith("Transformation")]


def linear(element: Xml.Element) -> Affine:
    """The factor and the offset of a LinearTransformation."""
    return Affine(float(_number(element.get("factor", "1"), float)), float(_number(element.get("offset", "0"), float)))
