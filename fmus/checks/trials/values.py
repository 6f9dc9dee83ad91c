"""Every variable can be read, has the start value of the description, and lies within its bounds."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from fmus.checks.calls import CallFailedError
from fmus.checks.instance import Instance
from fmus.checks.model import FLOATS, Variable, whole
from fmus.checks.problem import Problem
from fmus.checks.settings import start_data, start_values
from fmus.checks.trial import Trial

PLACE, SEVERITY = 5, "error"
SAME = {"Float32": 1e-5}  # relative deviation of a start value: descriptions are written with six digits
SHOWN = 5  # problems of one sort that are listed


def applies(trial: Trial) -> bool:
    return True


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.initialised()
    groups: dict[str, list[Variable]] = {}
    for variable in trial.model.variables:
        if (
            not variable.clocks
            and variable.type != "Clock"
            and variable.reference is not None
            and trial.model.size(variable)
        ):
            groups.setdefault(variable.type, []).append(variable)
    for kind, group in groups.items():
        read = _reader(kind)
        try:
            found = read(fmu, group)
        except CallFailedError as failed:
            culprit = _culprit(trial, group, read)
            yield trial.error(f"{failed.message}, reading {culprit.name}", failed.call)
            fmu.abandon()
            fmu = trial.initialised()
            continue
        judge = {"String": _texts, "Binary": _binaries}.get(kind, _numbers)
        yield from list(judge(trial, fmu, group, found))[:SHOWN]


def _reader(kind: str) -> Callable[[Instance, list[Variable]], Any]:
    return {"String": Instance.texts, "Binary": Instance.binaries}.get(kind, Instance.get)


def _culprit(trial: Trial, group: list[Variable], read: Callable[[Instance, list[Variable]], Any]) -> Variable:
    """The first variable of a group that cannot be read, by bisection with an instance for each attempt."""
    while len(group) > 1:
        first = group[: len(group) // 2]
        fmu = trial.initialised()
        try:
            read(fmu, first)
            group = group[len(group) // 2 :]
        except CallFailedError:
            group = first
        fmu.abandon()
    return group[0]


def _set_by_importer(variable: Variable) -> bool:
    return variable.causality in ("parameter", "input", "structuralParameter") or variable.variability == "constant"


def _numbers(trial: Trial, fmu: Instance, group: list[Variable], values: np.ndarray) -> Iterator[Problem]:
    place = 0
    for variable in group:
        size = trial.model.size(variable)
        own = values[place : place + size]
        place += size
        start = start_values(variable, size)
        if start is not None and _set_by_importer(variable):
            unequal = np.abs(own.astype(float) - start) > SAME.get(variable.type, 1e-5) * np.maximum(
                np.abs(start), 1e-12
            )
            if unequal.any():
                k = int(np.argmax(unequal))
                what = f"{variable.name} is {own[k]:.9g} after initialisation"
                message = f"{what}, its start in the description is {start[k]:.9g}"
                yield trial.error(message, fmu.last, trial.section("2.2.7", "2.4.7.4"))
        yield from _bounds(trial, fmu, variable, own)


def _bounds(trial: Trial, fmu: Instance, variable: Variable, values: np.ndarray) -> Iterator[Problem]:
    """Integers have to keep their bounds; for reals these state the range of validity, up to the solver's tolerance."""
    if variable.causality not in ("output", "local") or variable.type == "Boolean":
        return
    scale = 1e-6 * max(1.0, *(abs(b) for b in (variable.low, variable.high) if np.isfinite(b)), 0.0)
    slack = scale if variable.type in FLOATS else 0.0
    outside = (values < variable.low - slack) | (values > variable.high + slack)
    if outside.any():
        report = trial.warning if variable.type in FLOATS else trial.error
        bounds = f"{variable.low:g} to {variable.high:g}"
        message = f"{variable.name} is {values[np.argmax(outside)]:.9g}, outside its bounds {bounds}"
        yield report(message, fmu.last, trial.section("2.2.7", "2.2.7.3"))


def _texts(trial: Trial, fmu: Instance, group: list[Variable], values: list[bytes]) -> Iterator[Problem]:
    for variable, own in _split(trial, group, values):
        try:
            texts = [value.decode() for value in own]
        except UnicodeDecodeError:
            yield trial.error(f"{variable.name} is not UTF-8", fmu.last, trial.section("2.1.2", "2.2.3"))
            continue
        yield from _started(trial, fmu, variable, own, texts)


def _binaries(trial: Trial, fmu: Instance, group: list[Variable], values: list[bytes]) -> Iterator[Problem]:
    for variable, own in _split(trial, group, values):
        most, size = whole(variable.typed.get("maxSize")), max(map(len, own), default=0)
        if most is not None and size > most:
            message = f"{variable.name} has {size} bytes, its maxSize is {most}"
            yield trial.error(message, fmu.last, trial.section("", "2.4.4"))
        yield from _started(trial, fmu, variable, own, [value[:8].hex() for value in own])


def _split(trial: Trial, group: list[Variable], values: list[bytes]) -> Iterator[tuple[Variable, list[bytes]]]:
    place = 0
    for variable in group:
        size = trial.model.size(variable)
        yield variable, values[place : place + size]
        place += size


def _started(
    trial: Trial, fmu: Instance, variable: Variable, values: list[bytes], shown: list[str]
) -> Iterator[Problem]:
    """Whether the importer's variables have their start values; the values are shown as texts."""
    start = start_data(variable, len(values)) if variable.start is not None and _set_by_importer(variable) else None
    if start is not None and start != values:
        k = next(k for k, (a, b) in enumerate(zip(start, values, strict=True)) if a != b)
        wanted = start[k].decode() if variable.type == "String" else start[k][:8].hex()
        message = f"{variable.name} is {shown[k]!r} after initialisation, its start in the description is {wanted!r}"
        yield trial.warning(message, fmu.last, trial.section("2.2.7", "2.4.7.4"))
