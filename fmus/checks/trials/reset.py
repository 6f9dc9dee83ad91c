"""A second run after a reset gives the numbers of the first one, and so does a run of another instance."""

from collections.abc import Iterator

from fmus.checks.problem import Problem
from fmus.checks.simulation import difference
from fmus.checks.trial import Trial

PLACE, SEVERITY = 20, "error"


def applies(trial: Trial) -> bool:
    return True


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.initialised()
    first = trial.simulate(fmu)
    fmu.reset()
    last = fmu.last
    fmu.initialise()
    again = trial.simulate(fmu, len(first.rows) - 1)
    differs = difference(first, again)
    if not differs:
        return
    fmu.close()
    other = trial.initialised()
    between = difference(first, trial.simulate(other, len(first.rows) - 1))
    if between:
        yield trial.warning(f"two runs of the same experiment differ: {between}")
    else:
        yield trial.error(f"a run after a reset differs from the first one: {differs}", last)
