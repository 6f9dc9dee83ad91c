"""Names of variables: unique, and as the naming convention demands."""

import re

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.problem import Problem

STAGE = "description"
SHOWN = 10
B_NAME = r"(?:[A-Za-z_][A-Za-z_0-9]*|'(?:[^'\\]|\\.)+')"
INDICES = r"(?:\[[0-9]+(?:,[0-9]+)*\])?"
IDENTIFIER = rf"{B_NAME}{INDICES}(?:\.{B_NAME}{INDICES})*"
STRUCTURED = re.compile(rf"{IDENTIFIER}|der\({IDENTIFIER}(?:,[0-9]+)?\)")


def check(fmu: CheckedFmu) -> list[Problem]:
    """Names that are not unique, empty or not in the convention."""
    found, seen, reported = [], set(), set()
    structured = fmu.root.get("variableNamingConvention") == "structured"
    names = [name for v in fmu.model.variables for name in (v.name, *(str(a.get("name")) for a in v.aliases))]
    for name in names:
        if name in seen and name not in reported:
            reported.add(name)
            found.append(fmu.error("names", f"the name {name!r} is not unique", name, "2.2.7", "2.4.7.4"))
        seen.add(name)
        if not name:
            found.append(fmu.error("names", "a variable has an empty name", "ModelVariables", "2.2.7", "2.4.7.4"))
        elif structured and not STRUCTURED.fullmatch(name):
            found.append(
                fmu.error("names", f"{name!r} is no name of the convention `structured`", name, "2.2.9", "2.4.7.5")
            )
        elif not structured and any(character in name for character in "\r\n\t"):
            found.append(fmu.error("names", f"{name!r} has a line feed or a tab", name, "2.2.9", "2.4.7.5"))
    return found[:SHOWN]
