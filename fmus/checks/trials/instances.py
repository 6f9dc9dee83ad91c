"""Two instances in one process do not touch each other."""

from collections.abc import Iterator

import numpy as np

from fmus.checks.problem import Problem
from fmus.checks.simulation import recorded, values
from fmus.checks.trial import Trial

PLACE, SEVERITY = 50, "error"


def applies(trial: Trial) -> bool:
    return not trial.flag("canBeInstantiatedOnlyOncePerProcess", "canBeInstantiatedOnlyOncePerProcess")


def run(trial: Trial) -> Iterator[Problem]:
    still, moved = trial.initialised(), trial.initialised()
    variables = recorded(trial.model)
    before = values(still, variables)
    trial.simulate(moved, 20)
    if not np.array_equal(values(still, variables), before, equal_nan=True):
        yield trial.error(
            "values of one instance change with the steps of another", still.last, trial.section("2.1.5", "2.3.1")
        )
    moved.close()
    trial.simulate(still, 3)
