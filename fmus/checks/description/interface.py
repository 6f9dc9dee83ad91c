"""The description's head: kinds, identifiers, token, date, default experiment."""

import math
import re
from collections.abc import Iterator

from fmus.checks.checked_fmu import FILE, CheckedFmu
from fmus.checks.problem import Problem

STAGE = "description"
UTC = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?Z")
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
VERSIONS = {"2": re.compile(r"2\.0"), "3": re.compile(r"3\.(0(\.[0-9]+)?(-.+)?|[1-9].*)")}


def check(fmu: CheckedFmu) -> list[Problem]:
    """What is missing or wrong."""
    return _head(fmu) + _experiment(fmu)


def _head(fmu: CheckedFmu) -> list[Problem]:
    root, found = fmu.root, []
    version, date = str(root.get("fmiVersion")), root.get("generationDateAndTime")
    if not VERSIONS[fmu.version].fullmatch(version):
        found.append(fmu.error("version", f"fmiVersion {version!r} is none of the standard", FILE, "2.2.1", "2.4.1"))
    if not fmu.model.kinds:
        found.append(
            fmu.error(
                "interface",
                "has neither model exchange nor co-simulation nor scheduled execution",
                FILE,
                "2.2.1",
                "2.4.1",
            )
        )
    if not fmu.model.token:
        what = "guid" if fmu.version == "2" else "instantiationToken"
        found.append(fmu.error("interface", f"has no {what}", FILE, "2.2.1", "2.4.1"))
    if date is not None and not UTC.fullmatch(date):  # the standard: "should be"
        message = f"generationDateAndTime {date!r} is not of the form 2024-01-31T12:00:00Z"
        found.append(fmu.warning("date", message, FILE, "2.2.1", "2.4.1"))
    for kind in fmu.model.kinds:
        identifier = fmu.root.find(kind).get("modelIdentifier") or ""  # type: ignore[union-attr]
        if not IDENTIFIER.fullmatch(identifier):
            found.append(
                fmu.error("interface", f"modelIdentifier {identifier!r} is no C identifier", kind, "2.1.1", "2.2.2")
            )
    return [*found, *_steps(fmu)]


def _steps(fmu: CheckedFmu) -> Iterator[Problem]:
    """FMI 3: what is said of early return and of intermediate updates."""
    early, provided = "canReturnEarlyAfterIntermediateUpdate", "providesIntermediateUpdate"
    if fmu.model.flag("CoSimulation", "", early) and not fmu.model.flag("CoSimulation", "", provided):
        yield fmu.error("interface", f"{early} is true, but {provided} is not", "CoSimulation", "", "4.4")
    for variable in fmu.model.variables:
        if variable.element.get("intermediateUpdate") in ("true", "1") and variable.variability != "continuous":
            message = f"has intermediateUpdate, but variability {variable.variability}"
            yield fmu.error("interface", message, variable.name, "", "2.4.7.4")


def _experiment(fmu: CheckedFmu) -> list[Problem]:
    element = fmu.root.find("DefaultExperiment")
    if element is None:
        return []
    found = []
    values = {
        name: fmu.model.experiment(name)
        for name in ("startTime", "stopTime", "tolerance", "stepSize")
        if element.get(name) is not None
    }
    for name, value in values.items():
        if not math.isfinite(value):
            found.append(
                fmu.error(
                    "experiment",
                    f"{name} is {element.get(name)}, no finite number",
                    "DefaultExperiment",
                    "2.2.5",
                    "2.4.6",
                )
            )
        elif name in ("tolerance", "stepSize") and value <= 0:
            found.append(
                fmu.error("experiment", f"{name} {value:g} is not positive", "DefaultExperiment", "2.2.5", "2.4.6")
            )
    if values.get("stopTime", math.inf) < values.get("startTime", 0.0):
        found.append(
            fmu.error(
                "experiment",
                f"stopTime {values['stopTime']:g} is before startTime {values.get('startTime', 0.0):g}",
                "DefaultExperiment",
                "2.2.5",
                "2.4.6",
            )
        )
    return found
