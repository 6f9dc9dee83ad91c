"""Two instances in one process with different inputs and parameters: each gives the numbers that it gives alone."""

import time
from collections.abc import Iterator, Sequence

from fmus.checks.calls import EndedError, FmiCall
from fmus.checks.excitation import (
    KEPT,
    REFUSED,
    SECONDS,
    Excitation,
    Given,
    NotAcceptedError,
    changed_parameters,
    first_run,
    put,
)
from fmus.checks.problem import Problem
from fmus.checks.simulation import Run, Simulation, difference, step_size, steps
from fmus.checks.trial import Trial

PLACE, SEVERITY = 51, "error"
COUNT = 30  # communication steps


def applies(trial: Trial) -> bool:
    once = trial.flag("canBeInstantiatedOnlyOncePerProcess", "canBeInstantiatedOnlyOncePerProcess")
    return not once and (bool(Excitation(trial)) or bool(changed_parameters(trial)))


def run(trial: Trial) -> Iterator[Problem]:
    trial.seconds = SECONDS
    drives: list[Excitation | None] = [Excitation(trial) or None, Excitation(trial, second=True) or None]
    parameters = changed_parameters(trial)
    try:
        alone = [_alone(trial, drive) for drive in drives]
    except NotAcceptedError as reason:
        yield trial.note(REFUSED.format(reason))
        drives = [None, None]
        alone = [_alone(trial, drive) for drive in drives]
    try:
        alone[1] = _alone(trial, drives[1], parameters)
    except NotAcceptedError as reason:
        yield trial.note(KEPT.format(reason))
        parameters = []
    if not any(drives) and not parameters:
        return
    differs, call = _together(trial, drives, parameters, alone)
    again = [_alone(trial, drives[0]), _alone(trial, drives[1], parameters)]
    if differs and not any(map(difference, alone, again)):  # else no two runs agree
        section = trial.section("2.1.5", "2.3.1")
        yield trial.error(
            f"values of one instance change with the inputs or parameters of another: {differs}", call, section
        )


def _alone(trial: Trial, drive: Excitation | None, parameters: Sequence[Given] = ()) -> Run:
    found = first_run(trial, COUNT, drive, parameters)
    found.fmu.close()
    return found.run


def _together(
    trial: Trial, drives: Sequence[Excitation | None], parameters: Sequence[Given], alone: Sequence[Run]
) -> tuple[str, FmiCall]:
    """The first difference of two instances that run at the same time from each alone, and the last call."""
    first = trial.initialised()
    second = trial.instance()
    put(second, parameters)
    second.initialise()
    pair = [Simulation(fmu, drive) for fmu, drive in zip((first, second), drives, strict=True)]
    step, began = step_size(trial.model, trial.kind), time.monotonic()
    try:
        for _ in range(min(COUNT, steps(trial.model, trial.kind))):
            for one in pair:
                one.put()
            went_on = [one.advance(step) for one in pair]
            if not all(went_on) or time.monotonic() - began > trial.seconds:
                break
            for one in pair:
                one.record()
    except EndedError:
        pass
    found = next(filter(None, (difference(a, one.run) for a, one in zip(alone, pair, strict=True))), "")
    call = first.last
    second.close()
    first.close()
    return found, call
