"""Units of measure as FMI and SSP files define them, and conversions.

    value in base units = factor * value in the unit + offset
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree as Xml

from fmpy.model_description import ModelDescription

from fmus.cosimulation.ssp.package import SSC
from fmus.declaration.units import BASE, unit
from fmus.support.errors import InputError

EXPONENTS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Affine:
    """value -> factor * value + offset"""

    factor: float = 1.0
    offset: float = 0.0

    def __call__(self, value: float) -> float:
        return self.factor * value + self.offset

    def then(self, other: "Affine") -> "Affine":
        """First this one, then the other."""
        return Affine(self.factor * other.factor, other(self.offset))


IDENTITY = Affine()


@dataclass(frozen=True)
class UnitDefinition:
    """A unit by its exponents of the base units, factor and offset; without exponents only the name is known."""

    name: str
    exponents: tuple[int, ...] | None = None
    factor: float = 1.0
    offset: float = 0.0


def defined_units(units: Iterable[Xml.Element]) -> dict[str, UnitDefinition]:
    """The units of the elements `Units` of a file by name. Raises InputError for a number that is none."""
    return {
        each.get("name", ""): _definition(each.get("name", ""), base.attrib)
        for group in units
        for each in group.iterfind(f"{{{SSC}}}Unit")
        if (base := each.find(f"{{{SSC}}}BaseUnit")) is not None
    }


def units_of_fmu(description: ModelDescription) -> dict[str, UnitDefinition]:
    """The units of a model description by name."""
    return {
        each.name: _definition(each.name, {n: getattr(each.baseUnit, n) for n in (*EXPONENTS, "factor", "offset")})
        for each in description.unitDefinitions
        if each.baseUnit is not None
    }


def _definition(name: str, base: Mapping[str, Any]) -> UnitDefinition:
    try:
        exponents = tuple(int(base.get(n) or 0) for n in EXPONENTS)
        factor, offset = (float(base.get(n, default)) for n, default in (("factor", 1.0), ("offset", 0.0)))
    except ValueError as error:
        raise InputError(f"the unit {name} is not defined by numbers: {error}") from None
    if not abs(factor) > 0 or factor in (float("inf"), -float("inf")):
        raise InputError(f"the unit {name} has the factor {factor:g}, which must be finite and not zero")
    return UnitDefinition(name, exponents, factor, offset)


def named_unit(name: str | None, defined: Mapping[str, UnitDefinition]) -> UnitDefinition | None:
    """The unit of that name: as the file defines it, else as this project knows it; None without a name."""
    if not name:
        return None
    if name in defined:
        return defined[name]
    try:
        known = unit(name)
    except InputError:
        return UnitDefinition(name)
    exponents = dict(zip(BASE, known.exponents, strict=True))
    return UnitDefinition(name, tuple(exponents.get(n, 0) for n in EXPONENTS), known.factor)


def conversion(given: UnitDefinition | None, wanted: UnitDefinition | None) -> Affine:
    """From one unit to the other; none is made where a unit is not stated, or where both have the same name.

    Raises InputError where the dimensions differ and where a unit is not defined.
    """
    if given is None or wanted is None or given.name == wanted.name:
        return IDENTITY
    for each in (given, wanted):
        if each.exponents is None:
            raise InputError(f"[{given.name}] cannot be converted to [{wanted.name}]: [{each.name}] is not defined")
    if given.exponents != wanted.exponents:
        raise InputError(f"[{given.name}] cannot be converted to [{wanted.name}]: the dimensions differ")
    return Affine(given.factor / wanted.factor, (given.offset - wanted.offset) / wanted.factor)
