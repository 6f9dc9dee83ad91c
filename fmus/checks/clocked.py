"""Clocks of FMI 3: which can be activated when, their intervals, and the variables that belong to them (2.2.8)."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fmus.checks.instance import Instance
from fmus.checks.model import Model, Variable, number, whole
from fmus.checks.problem import Problem
from fmus.checks.simulation import read_all
from fmus.checks.trial import Trial

PERIODIC, APERIODIC = ("constant", "fixed", "tunable"), ("changing", "countdown")
NOT_YET_KNOWN, CHANGED = 0, 2  # fmi3IntervalNotYetKnown, fmi3IntervalChanged


@dataclass(frozen=True)
class Interval:
    """An interval [s] as an FMU gives it, with its qualifier."""

    seconds: float
    qualifier: int


@dataclass(frozen=True)
class Timing:
    """When a time-based clock ticks [s]: the first time after the start, and how much later the second time."""

    first: float
    period: float


def clocks(model: Model, *causalities: str) -> list[Variable]:
    """The clocks of these causalities that are no clocked variables themselves, which need another clock's tick."""
    return [v for v in model.variables if v.type == "Clock" and v.causality in causalities and not v.clocks]


def variability(clock: Variable) -> str:
    return clock.element.get("intervalVariability") or ""


def belonging(model: Model, active: Sequence[Variable]) -> list[Variable]:
    """The variables that belong to an active clock, other than clocks."""
    ticking = {clock.reference for clock in active}
    clocked = [v for v in model.variables if v.type != "Clock" and v.reference is not None and model.size(v)]
    return [v for v in clocked if ticking & {whole(word) for word in (v.clocks or "").split()}]


def interval(fmu: Instance, clock: Variable) -> Interval:
    """The interval that an FMU gives for a clock. Raises CallFailedError."""
    seconds = fmu.ffi.new("double[]", 1)
    qualifier = fmu.ffi.new(fmu.library.types["fmi3GetIntervalDecimal"].args[4])
    fmu.call("GetIntervalDecimal", fmu.references([clock]), 1, seconds, qualifier)
    return Interval(seconds[0], int(qualifier[0]))


def timings(trial: Trial, fmu: Instance) -> tuple[dict[str, Timing], list[Problem]]:
    """The ticks of the time-based clocks by name, in initialisation mode: from the description, or from the FMU where
    the importer has to ask for them (the table of 2.2.8.2); and what is wrong with them."""
    found: dict[str, Timing] = {}
    problems: list[Problem] = []
    for clock in clocks(trial.model, "input"):
        kind, asked = variability(clock), clock.element.get("intervalDecimal") is None
        first, every = shift(clock), period(clock)
        if kind in APERIODIC or (kind in ("fixed", "tunable") and asked):
            given = interval(fmu, clock)
            problems += judged(trial, fmu, clock, given)
            every = given.seconds
            if kind in APERIODIC:
                first = math.inf if given.qualifier == NOT_YET_KNOWN else given.seconds
            else:
                first = _asked_shift(fmu, clock)
                if not first >= 0:
                    message = f"{fmu.last.name} gives the shift {first:g} s for clock {clock.name}"
                    problems.append(trial.error(message, fmu.last))
        if kind in PERIODIC + APERIODIC:
            found[clock.name] = Timing(first, every)
    return found, problems


def _asked_shift(fmu: Instance, clock: Variable) -> float:
    seconds = fmu.ffi.new("double[]", 1)
    fmu.call("GetShiftDecimal", fmu.references([clock]), 1, seconds)
    return float(seconds[0])


def judged(trial: Trial, fmu: Instance, clock: Variable, found: Interval) -> Iterator[Problem]:
    """Periods are positive, other intervals not negative."""
    periodic = variability(clock) in PERIODIC
    valid = found.seconds > 0 if periodic else found.seconds >= 0
    if (periodic or found.qualifier == CHANGED) and not valid:
        what = f"gives the interval {found.seconds:g} s for clock {clock.name}"
        yield trial.error(f"{fmu.last.name} {what}", fmu.last)


def ticking(fmu: Instance, model: Model) -> list[Variable]:
    """The output and local clocks that tick."""
    asked = clocks(model, "output", "local")
    active = fmu.ffi.new("bool[]", len(asked))
    if asked:
        fmu.call("GetClock", fmu.references(asked), len(asked), active)
    return [clock for clock, ticks in zip(asked, active, strict=True) if ticks]


def read(fmu: Instance, model: Model, active: Sequence[Variable]) -> None:
    """Read every variable that belongs to an active clock. Raises CallFailedError."""
    read_all(fmu, belonging(model, active))


def shift(clock: Variable) -> float:
    """The time from the start to the first tick of a periodic clock [s], as the description has it."""
    counter, resolution = (number(clock.element.get(name), 0.0) for name in ("shiftCounter", "resolution"))
    return number(clock.element.get("shiftDecimal"), counter / resolution if resolution else 0.0)


def period(clock: Variable) -> float:
    """The interval of a periodic clock [s] in the description; NaN where it has none."""
    counter, resolution = (number(clock.element.get(name), 0.0) for name in ("intervalCounter", "resolution"))
    return number(clock.element.get("intervalDecimal"), counter / resolution if counter and resolution else math.nan)
