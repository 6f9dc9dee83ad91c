"""The model description: fmpy's validation with its schemas, fmutool where it is installed, and checks
that neither makes."""

import json
import re
import subprocess
import sys
from importlib.util import find_spec
from math import inf, nan
from pathlib import Path
from xml.etree import ElementTree as Xml

from fmus.checks.checked_fmu import FILE, CheckedFmu
from fmus.checks.problem import Problem

STAGE = "description"
TIME_LIMIT = 60.0  # s, of another tool
UTC = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ")


def check(fmu: CheckedFmu) -> list[Problem]:
    """Problems of the model description."""
    return _fmpy(fmu.path) + _fmutool(fmu.path) + _date(fmu.root) + _bounds(fmu) + _references(fmu) + _units(fmu)


def _fmpy(path: Path) -> list[Problem]:
    """What fmpy's validation reports."""
    said = _from_python(
        "import json, sys; from fmpy.validation import validate_fmu; print(json.dumps([str(p) for p in "
        "validate_fmu(sys.argv[1])]))",
        path,
    )
    if said is None:
        return [Problem("fmpy", "warning", f"did not finish within {TIME_LIMIT:g} s", FILE)]
    try:
        return [Problem("fmpy", "error", " ".join(p.split()), FILE) for p in json.loads(said[0])]
    except ValueError:
        return [Problem("fmpy", "error", said[1].strip().rpartition("\n")[2] or "ended without a report", FILE)]


def _fmutool(path: Path) -> list[Problem]:
    """What `fmutool -check` reports, where it is installed."""
    if find_spec("fmu_manipulation_toolbox") is None:
        return []
    said = _from_python(
        "import sys; from fmu_manipulation_toolbox.cli.fmutool import fmutool; sys.exit(fmutool())",
        "-input",
        path,
        "-check",
    )
    if said is None:
        return [Problem("fmutool", "warning", f"did not finish within {TIME_LIMIT:g} s", path.name)]
    return [
        Problem("fmutool", "error", line, FILE)
        for line in re.findall(r"^ERROR\s*\|\s*(.*)$", "".join(said), re.MULTILINE)
    ]


def _from_python(code: str, *arguments: str | Path) -> tuple[str, str] | None:
    """What a line of Python writes in a process of its own; None when it takes too long."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", code, *map(str, arguments)],
            capture_output=True,
            text=True,
            timeout=TIME_LIMIT,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return None
    return done.stdout, done.stderr


def _date(root: Xml.Element) -> list[Problem]:
    date = root.get("generationDateAndTime")
    if date is None or UTC.fullmatch(date):
        return []
    return [Problem("date", "error", f"generationDateAndTime {date!r} is not of the form 2024-01-31T12:00:00Z", FILE)]


def _number(text: str | None, otherwise: float) -> float:
    try:
        return otherwise if text is None else float(text)
    except ValueError:  # an array's list of starts, or what the schema has reported already
        return nan


def _bounds(fmu: CheckedFmu) -> list[Problem]:
    found = []
    for variable in fmu.variables:
        element = variable if fmu.version == "3" else next(iter(variable), variable)
        low, high = _number(element.get("min"), -inf), _number(element.get("max"), inf)
        start, name = _number(element.get("start"), nan), str(variable.get("name"))
        if low > high:
            found.append(Problem("bounds", "error", f"min {low:g} is above max {high:g}", name))
        elif start < low:
            found.append(Problem("bounds", "error", f"min {low:g} is above start {start:g}", name))
        elif start > high:
            found.append(Problem("bounds", "error", f"start {start:g} is above max {high:g}", name))
    return found


def _references(fmu: CheckedFmu) -> list[Problem]:
    """Every index (FMI 2) or value reference (FMI 3) of the model structure names a variable."""
    variables = fmu.variables
    if fmu.version == "2":
        known, attribute, meaning = (
            {str(i + 1) for i in range(len(variables))},
            "index",
            f"variable (valid: 1 to {len(variables)})",
        )
    else:
        known, attribute, meaning = (
            {str(v.get("valueReference")) for v in variables},
            "valueReference",
            "value reference of a variable",
        )
    found = []
    for unknown in fmu.root.iterfind("ModelStructure//*[@" + attribute + "]"):
        given = [str(unknown.get(attribute)), *(unknown.get("dependencies") or "").split()]
        found += [
            Problem("structure", "error", f"{number} is no {meaning}", f"ModelStructure, {unknown.tag} {given[0]}")
            for number in given
            if number not in known
        ]
    return found


def _units(fmu: CheckedFmu) -> list[Problem]:
    """Units that are defined and used; a real variable without one is worth a warning."""
    defined = {u.get("name") for u in fmu.root.iterfind("UnitDefinitions/Unit")}
    typed = {
        t.get("name"): (t if fmu.version == "3" else next(iter(t), t)) for t in fmu.root.iterfind("TypeDefinitions/*")
    }
    found, without = [], []
    for variable in fmu.variables:
        element = variable if fmu.version == "3" else next(iter(variable), variable)
        if element.tag not in ("Real", "Float64"):
            continue
        declared = typed.get(element.get("declaredType"))
        unit = element.get("unit") or (declared.get("unit") if declared is not None else None)
        if unit is None:
            without.append(str(variable.get("name")))
        elif unit not in defined:
            found.append(Problem("units", "error", f"unit [{unit}] is not defined", str(variable.get("name"))))
    if without:
        found.append(
            Problem("units", "warning", f"{len(without)} real variables have no unit, the first is {without[0]}", FILE)
        )
    return found
