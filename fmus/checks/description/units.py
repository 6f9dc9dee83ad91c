"""Units: defined once, with a usable factor; a real variable without one is worth a warning."""

import math
from collections import Counter

from fmus.checks.checked_fmu import FILE, CheckedFmu
from fmus.checks.model import number
from fmus.checks.problem import Problem

STAGE = "description"


def check(fmu: CheckedFmu) -> list[Problem]:
    """Units that are not defined, twice defined or cannot be converted."""
    units = fmu.root.findall("UnitDefinitions/Unit")
    found = [
        fmu.error("units", f"unit [{name}] is defined {count} times", FILE, "2.2.2", "2.4.3")
        for name, count in Counter(unit.get("name") for unit in units).items()
        if count > 1
    ]
    for unit in units:
        for element in [*unit.findall("BaseUnit"), *unit.findall("DisplayUnit")]:
            what = f"unit [{unit.get('name')}]" + (
                f", display unit [{element.get('name')}]" if element.tag == "DisplayUnit" else ""
            )
            factor, offset = number(element.get("factor"), 1.0), number(element.get("offset"), 0.0)
            if not math.isfinite(factor) or factor == 0:
                found.append(
                    fmu.error(
                        "units",
                        f"{what} has the factor {factor:g}, no finite number other than zero",
                        FILE,
                        "2.2.2",
                        "2.4.3",
                    )
                )
            if not math.isfinite(offset):
                found.append(
                    fmu.error("units", f"{what} has the offset {offset:g}, no finite number", FILE, "2.2.2", "2.4.3")
                )
    return found + _used(fmu)


def _used(fmu: CheckedFmu) -> list[Problem]:
    displays = {
        u.get("name"): {d.get("name") for d in u.findall("DisplayUnit")}
        for u in fmu.root.iterfind("UnitDefinitions/Unit")
    }
    found, without = [], []
    for variable in fmu.model.variables:
        if not variable.real:
            continue
        display = variable.typed.get("displayUnit")
        if variable.unit is None:
            if variable.causality != "independent":
                without.append(variable.name)
            if display is not None:
                found.append(
                    fmu.error(
                        "units", f"has the display unit [{display}] but no unit", variable.name, "2.2.7", "2.4.7.5"
                    )
                )
        elif variable.unit not in displays:
            found.append(fmu.error("units", f"unit [{variable.unit}] is not defined", variable.name, "2.2.2", "2.4.3"))
        elif display is not None and display not in displays[variable.unit]:
            found.append(
                fmu.error(
                    "units",
                    f"display unit [{display}] of unit [{variable.unit}] is not defined",
                    variable.name,
                    "2.2.2",
                    "2.4.3",
                )
            )
    for name, declared in fmu.model.types.items():
        if declared.get("unit") is not None and declared.get("unit") not in displays:
            found.append(
                fmu.error("units", f"unit [{declared.get('unit')}] is not defined", f"type {name}", "2.2.3", "2.4.4")
            )
    if without:
        some = f"{len(without)} real variable{'s have' if len(without) > 1 else ' has'} no unit"
        found.append(fmu.warning("units", f"{some}, the first is {without[0]}", FILE, "2.2.2", "2.4.3"))
    return found
