"""Value references: unique in FMI 3, shared by alias variables of one type in FMI 2."""

from collections import defaultdict

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.model import Variable
from fmus.checks.problem import Problem

STAGE = "description"


def check(fmu: CheckedFmu) -> list[Problem]:
    """References that two variables may not share."""
    sets: dict[tuple[str, int | None], list[Variable]] = defaultdict(list)
    for variable in fmu.model.variables:
        base = "Integer" if variable.type == "Enumeration" else variable.type
        sets[base if fmu.version == "2" else "", variable.reference].append(variable)
    shared = [group for group in sets.values() if len(group) > 1]
    if fmu.version == "3":
        return [
            fmu.error(
                "references", f"has the value reference {g[1].reference} of {g[0].name}", g[1].name, "", "2.4.7.4"
            )
            for g in shared
        ]
    return [problem for group in shared for problem in _aliases(fmu, group)]


def _aliases(fmu: CheckedFmu, group: list[Variable]) -> list[Problem]:
    found = []
    settable = [v for v in group if v.causality in ("input", "parameter")]
    if len(settable) > 1:
        found.append(
            fmu.error(
                "references",
                f"is a settable variable with the value reference {settable[1].reference} of {settable[0].name}",
                settable[1].name,
                "2.2.7",
            )
        )
    started = [v for v in group if v.start is not None and v.variability != "constant"]
    if len(started) > 1 and len(settable) <= 1:
        found.append(
            fmu.error(
                "references",
                f"and {started[0].name} share a value reference and have both a start value",
                started[1].name,
                "2.2.7",
            )
        )
    constant = [v for v in group if v.variability == "constant"]
    if constant and len(constant) < len(group):
        found.append(
            fmu.error(
                "references",
                "is a constant that shares its value reference with a variable that is none",
                constant[0].name,
                "2.2.7",
            )
        )
    if len({v.unit for v in group}) > 1:
        found.append(
            fmu.error(
                "references",
                f"and {group[0].name} share a value reference but have different units",
                group[1].name,
                "2.2.7",
            )
        )
    return found
