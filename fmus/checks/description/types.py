"""Declared types and enumerations."""

from collections import Counter

from fmus.checks.checked_fmu import FILE, CheckedFmu
from fmus.checks.model import whole
from fmus.checks.problem import Problem

STAGE = "description"


def check(fmu: CheckedFmu) -> list[Problem]:
    """Types that are missing or of another base type; items of enumerations; start values that are no item."""
    types, found = fmu.model.types, []
    names = Counter(t.get("name") for t in fmu.root.findall("TypeDefinitions/*"))
    found += [
        fmu.error("types", f"type {name!r} is defined {count} times", FILE, "2.2.3", "2.4.4")
        for name, count in names.items()
        if count > 1
    ]
    for name, declared in types.items():
        for attribute in ("name", "value"):
            items = Counter(item.get(attribute) for item in declared.findall("Item"))
            found += [
                fmu.error(
                    "types",
                    f"enumeration {name!r} has {count} items with the {attribute} {item!r}",
                    FILE,
                    "2.2.3",
                    "2.4.4",
                )
                for item, count in items.items()
                if count > 1
            ]
    for variable in fmu.model.variables:
        declared_name = variable.typed.get("declaredType")
        if declared_name is None:
            continue
        declared_type = types.get(declared_name)
        if declared_type is None:
            found.append(
                fmu.error(
                    "types", f"its declared type {declared_name!r} is not defined", variable.name, "2.2.7", "2.4.7.5"
                )
            )
        elif (base := declared_type.tag.removesuffix("Type")) != variable.type:
            message = f"is of type {variable.type}, its declared type {declared_name!r} of type {base}"
            found.append(fmu.error("types", message, variable.name, "2.2.7", "2.4.7.5"))
        elif variable.type == "Enumeration" and variable.start is not None:
            values = {whole(item.get("value")) for item in declared_type.findall("Item")}
            if any(whole(word) not in values for word in variable.start.split()):
                found.append(
                    fmu.error(
                        "types",
                        f"start {variable.start} is no item of {declared_name!r}",
                        variable.name,
                        "2.2.7",
                        "2.4.7.5",
                    )
                )
    return found
