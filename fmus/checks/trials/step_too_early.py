"""A communication step before initialisation."""

from collections.abc import Iterator

from fmus.checks.problem import Problem
from fmus.checks.provocation import provoke
from fmus.checks.settings import raw_step
from fmus.checks.simulation import step_size
from fmus.checks.trial import Trial

PLACE, SEVERITY = 87, "warning"


def applies(trial: Trial) -> bool:
    return trial.kind == "CoSimulation"


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.instance()
    yield from provoke(
        trial, fmu, "a step before initialisation", lambda: raw_step(fmu, step_size(trial.model, trial.kind))
    )
