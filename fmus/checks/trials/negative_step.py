"""A communication step back in time."""

from collections.abc import Iterator

from fmus.checks.problem import Problem
from fmus.checks.provocation import provoke
from fmus.checks.settings import raw_step
from fmus.checks.simulation import step_size
from fmus.checks.trial import Trial

PLACE, SEVERITY = 85, "warning"


def applies(trial: Trial) -> bool:
    return trial.kind == "CoSimulation"


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.initialised()
    fmu.do_step(step_size(trial.model, trial.kind))
    yield from provoke(trial, fmu, "a negative step", lambda: raw_step(fmu, -step_size(trial.model, trial.kind)))
