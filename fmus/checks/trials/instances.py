"""Two instances in one process do not touch each other."""

from collections.abc import Iterator

from fmus.checks.instance import Instance
from fmus.checks.problem import Problem
from fmus.checks.simulation import Run, difference
from fmus.checks.trial import Trial

PLACE, SEVERITY = 50, "error"
STEPS = 10


def applies(trial: Trial) -> bool:
    return not trial.flag("canBeInstantiatedOnlyOncePerProcess", "canBeInstantiatedOnlyOncePerProcess")


def run(trial: Trial) -> Iterator[Problem]:
    alone = _steps(trial, trial.initialised())
    still, other = trial.initialised(), trial.initialised()
    trial.simulate(other, 20)
    differs = difference(alone, trial.simulate(still, STEPS))
    call = still.last
    other.close()
    still.close()
    if differs and not difference(alone, _steps(trial, trial.initialised())):  # else no two runs agree
        yield trial.error(
            f"values of one instance change with the steps of another: {differs}", call, trial.section("2.1.5", "2.3.1")
        )


def _steps(trial: Trial, fmu: Instance) -> Run:
    found = trial.simulate(fmu, STEPS)
    fmu.close()
    return found
