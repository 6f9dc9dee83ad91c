"""Co-simulation: communication steps of different lengths, where the description permits them."""

from collections.abc import Iterator

from fmus.checks.calls import EndedError
from fmus.checks.problem import Problem
from fmus.checks.simulation import step_size
from fmus.checks.trial import Trial

PLACE, SEVERITY = 60, "error"


def applies(trial: Trial) -> bool:
    flag = "canHandleVariableCommunicationStepSize"
    return trial.kind == "CoSimulation" and trial.flag(flag, flag)


def run(trial: Trial) -> Iterator[Problem]:
    fmu, step = trial.initialised(), step_size(trial.model, trial.kind)
    try:
        for factor in (1, 2, 1, 3):
            fmu.do_step(factor * step)
    except EndedError:
        pass
    yield from ()
