"""A simulation of the default experiment from the start values: every call succeeds, every number is finite."""

from collections.abc import Iterator

import numpy as np

from fmus.checks.problem import Problem
from fmus.checks.trial import Trial

PLACE, SEVERITY = 2, "error"


def applies(trial: Trial) -> bool:
    return True


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.initialised()
    found = trial.simulate(fmu)
    bad = np.argwhere(~np.isfinite(found.values))
    if len(bad):
        row, column = bad[0]
        what = f"{found.names[column]} is {found.values[row, column]:g} at {found.times[row]:g} s"
        yield trial.error(f"{what} in a run from the start values", fmu.last, trial.section("2.1.7", "2.2.7.2"))
    if found.ended:
        yield trial.note(f"the FMU asks for the end of the simulation at {fmu.time:g} s")
