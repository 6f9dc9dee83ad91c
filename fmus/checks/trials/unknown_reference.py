"""Reading a real variable with a value reference that the description does not have."""

from collections.abc import Iterator
from dataclasses import replace

from fmus.checks.problem import Problem
from fmus.checks.provocation import provoke
from fmus.checks.trial import Trial

PLACE, SEVERITY = 81, "warning"


def _reals(trial: Trial) -> list:  # type: ignore[type-arg]
    return [v for v in trial.model.variables if v.type in ("Real", "Float64") and v.reference is not None]


def applies(trial: Trial) -> bool:
    return bool(_reals(trial))


def run(trial: Trial) -> Iterator[Problem]:
    known = {v.reference for v in trial.model.variables}
    nowhere = next(r for r in (1 + max(r for r in known if r is not None), 0, 2**31) if r not in known and r < 2**32)
    wrong = replace(_reals(trial)[0], reference=nowhere, dimensions=[])
    fmu = trial.initialised()
    yield from provoke(trial, fmu, f"a value reference that does not exist ({nowhere})", lambda: _read(fmu, wrong))


def _read(fmu, variable) -> int:  # type: ignore[no-untyped-def]
    fmu.get([variable])
    return 0
