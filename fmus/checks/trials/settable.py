"""Start values of the description can be set where the state machine permits: before and in initialisation, inputs and
tunable parameters after it."""

from collections.abc import Iterator

from fmus.checks.problem import Problem
from fmus.checks.settings import set_start
from fmus.checks.trial import Trial

PLACE, SEVERITY = 6, "error"


def applies(trial: Trial) -> bool:
    return True


def run(trial: Trial) -> Iterator[Problem]:
    given = [
        v
        for v in trial.model.variables
        if v.start is not None
        and v.type != "Clock"
        and v.reference is not None
        and not v.clocks
        and v.variability != "constant"
        and v.causality not in ("independent", "structuralParameter")
    ]
    inputs = [v for v in given if v.causality == "input"]
    exact = [v for v in given if v.initial == "exact" and v.causality != "input"]
    fmu = trial.instance()
    set_start(fmu, exact)
    fmu.enter_initialisation()
    set_start(fmu, exact + inputs)
    fmu.exit_initialisation()
    if fmu.exchange or fmu.steps_end_in_events:
        fmu.enter_event()
    set_start(fmu, inputs + [v for v in exact if v.causality == "parameter" and v.variability == "tunable"])
    if fmu.phase == "event":
        fmu.settle()
    trial.simulate(fmu, 3)
    yield from ()
