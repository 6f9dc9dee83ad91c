"""After the end of a simulation its values can be read, and the instance can be reset and used again."""

from collections.abc import Iterator

from fmus.checks.problem import Problem
from fmus.checks.simulation import recorded, values
from fmus.checks.trial import Trial

PLACE, SEVERITY = 70, "error"


def applies(trial: Trial) -> bool:
    return True


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.initialised()
    trial.simulate(fmu, 3)
    fmu.terminate()
    values(fmu, recorded(trial.model))
    fmu.reset()
    fmu.initialise()
    yield from ()
