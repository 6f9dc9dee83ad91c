"""FMI 3: structural parameters. The present sizes can be set; arrays take other sizes, or the FMU refuses these in
configuration mode."""

from collections.abc import Iterator
from copy import deepcopy

import numpy as np

from fmus.checks.calls import CallFailedError
from fmus.checks.instance import Instance
from fmus.checks.model import FLOATS, Model, Variable, whole
from fmus.checks.problem import Problem
from fmus.checks.simulation import recorded, values
from fmus.checks.trial import Trial

PLACE, SEVERITY = 62, "error"


def _parameters(model: Model) -> list[Variable]:
    return [v for v in model.variables if v.causality == "structuralParameter" and whole(v.start) is not None]


def applies(trial: Trial) -> bool:
    return bool(_parameters(trial.model))


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.instance()
    _configure(fmu, {p: int(p.start or 0) for p in _parameters(trial.model)})
    fmu.initialise()
    trial.simulate(fmu, 3)
    for parameter in _parameters(trial.model):
        if (size := _other(parameter)) is not None and _in_dimension(trial.model, parameter):
            yield from _resized(trial, parameter, size)


def _other(parameter: Variable) -> int | None:
    """Another admissible size: one more, else one less; None where there is none."""
    size = int(parameter.start or 0)
    return size + 1 if size + 1 <= parameter.high else size - 1 if size - 1 >= max(parameter.low, 1) else None


def _in_dimension(model: Model, parameter: Variable) -> bool:
    return any(whole(reference) == parameter.reference for v in model.variables for _, reference in v.dimensions)


def _configure(fmu: Instance, sizes: dict) -> None:  # type: ignore[type-arg]
    fmu.call("EnterConfigurationMode")
    for parameter, size in sizes.items():
        fmu.set([parameter], [size])
    fmu.call("ExitConfigurationMode")


def _resized(trial: Trial, parameter: Variable, size: int) -> Iterator[Problem]:
    root = deepcopy(trial.model.root)
    for element in root.findall("ModelVariables/*"):
        if element.get("valueReference") == str(parameter.reference):
            element.set("start", str(size))
    fmu = trial.instance()
    try:
        _configure(fmu, {parameter: size})
    except CallFailedError as failed:
        yield trial.note(f"refuses {size} for the structural parameter {parameter.name}", failed.call)
        fmu.abandon()
        return
    fmu.model = Model(root)
    affected = [v for v in fmu.model.variables if any(whole(r) == parameter.reference for _, r in v.dimensions)]
    # A new size invalidates the values of an array, start values too (FMI 3.0, 2.4.7.2).
    for variable in affected:
        if variable.causality in ("parameter", "input") and variable.type in FLOATS:
            fmu.set([variable], np.zeros(fmu.model.size(variable)))
    fmu.initialise()
    values(fmu, recorded(fmu.model))
    if fmu.exchange:
        fmu.states()
        fmu.rates()
