"""FMI 3: clocks in event mode. All can be read; triggered input clocks can be activated; intervals can be read."""

from collections.abc import Iterator

from fmus.checks.calls import EndedError
from fmus.checks.model import Variable
from fmus.checks.problem import Problem
from fmus.checks.trial import Trial

PLACE, SEVERITY = 63, "error"
CHANGED = 2  # fmi3IntervalChanged


def _clocks(trial: Trial) -> list[Variable]:
    return [v for v in trial.model.variables if v.type == "Clock"]


def applies(trial: Trial) -> bool:
    return bool(_clocks(trial)) and (trial.kind == "ModelExchange" or trial.flag("", "hasEventMode"))


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.instance()
    fmu.enter_initialisation()
    fmu.call("ExitInitializationMode")
    fmu.phase = "event"
    clocks = _clocks(trial)
    references, active = fmu.references(clocks), fmu.ffi.new("bool[]", len(clocks))
    fmu.call("GetClock", references, len(clocks), active)
    for clock in clocks:
        if clock.causality == "input":
            yield from _input(trial, clock)
    try:
        fmu.settle()
        trial.simulate(fmu, 3)
    except EndedError:
        yield trial.note("the FMU asks for the end of the simulation")


def _input(trial: Trial, clock: Variable) -> Iterator[Problem]:
    fmu, variability = trial.instances[-1], clock.element.get("intervalVariability")
    reference = fmu.references([clock])
    if variability == "triggered":
        fmu.call("SetClock", reference, 1, fmu.ffi.new("bool[]", [True]))
        return
    if variability == "countdown":  # the interval of others is asked for in other states
        interval, qualifier = (
            fmu.ffi.new("double[]", 1),
            fmu.ffi.new(trial.library.types["fmi3GetIntervalDecimal"].args[4]),
        )
        fmu.call("GetIntervalDecimal", reference, 1, interval, qualifier)
        if int(qualifier[0]) == CHANGED and not interval[0] >= 0:
            yield trial.error(f"{fmu.last.name} gives the interval {interval[0]:g} s for clock {clock.name}", fmu.last)
