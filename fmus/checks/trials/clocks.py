"""FMI 3: clocks. Intervals can be read, input clocks can be activated, and the variables of a clock can be read when it
ticks."""

from collections.abc import Iterator

from fmus.checks.calls import EndedError
from fmus.checks.clocked import (
    PERIODIC,
    clocks,
    interval,
    judged,
    read,
    ticking,
    timings,
    variability,
)  # fmt: skip
from fmus.checks.instance import Instance
from fmus.checks.model import Variable
from fmus.checks.problem import Problem
from fmus.checks.trial import Trial

PLACE, SEVERITY = 63, "error"


def applies(trial: Trial) -> bool:
    has = any(v.type == "Clock" for v in trial.model.variables)
    return has and (trial.kind == "ModelExchange" or trial.flag("", "hasEventMode"))


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.instance()
    fmu.enter_initialisation()
    times, problems = timings(trial, fmu)
    yield from problems
    fmu.call("ExitInitializationMode")
    fmu.phase = "event"
    inputs = clocks(trial.model, "input")
    try:
        due = [c for c in inputs if variability(c) in PERIODIC and times[c.name].first == 0]
        yield from _event(trial, fmu, due)
        for clock in inputs:
            if variability(clock) == "triggered":
                fmu.enter_event()
                yield from _event(trial, fmu, [clock])
        trial.simulate(fmu, 3)
    except EndedError:
        yield trial.note("the FMU asks for the end of the simulation")


def _event(trial: Trial, fmu: Instance, active: list[Variable]) -> Iterator[Problem]:
    """One event in which these input clocks tick, with all that follows from them."""
    if active:
        values = fmu.ffi.new("bool[]", [True] * len(active))
        fmu.call("SetClock", fmu.references(active), len(active), values)
    read(fmu, trial.model, [*active, *ticking(fmu, trial.model)])
    fmu.iterate()
    for clock in clocks(trial.model, "input"):  # intervals are computed by the iteration (2.3.5)
        if variability(clock) == "countdown":
            yield from judged(trial, fmu, clock, interval(fmu, clock))
    fmu.leave_event()
