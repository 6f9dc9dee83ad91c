"""With inputs that vary and parameters off their start values: a reset brings the instance back to the state after
instantiation, where all variables have their start values, and two runs of one experiment are equal."""

from collections.abc import Iterator

from fmus.checks.excitation import (
    KEPT,
    SECONDS,
    Excitation,
    First,
    NotAcceptedError,
    accepted_run,
    changed_parameters,
    first_run,
    settings,
)
from fmus.checks.problem import Problem
from fmus.checks.simulation import difference
from fmus.checks.trial import Trial

PLACE, SEVERITY = 21, "error"
COUNT = 100  # communication steps


def applies(trial: Trial) -> bool:
    return bool(Excitation(trial)) or bool(changed_parameters(trial))


def run(trial: Trial) -> Iterator[Problem]:
    trial.seconds = SECONDS
    first, notes = accepted_run(trial, COUNT)
    first.fmu.close()
    yield from notes
    drive = first.drive
    second = first_run(trial, COUNT, drive)
    if between := difference(first.run, second.run):
        second.fmu.close()
        yield trial.warning(f"two runs of the same experiment differ: {between}")
        return
    problems = list(_after_reset(trial, second, first, drive, ""))
    second.fmu.close()
    yield from problems
    if problems or not (parameters := changed_parameters(trial)):
        return
    try:
        changed = first_run(trial, COUNT, drive, parameters)
    except NotAcceptedError as reason:
        yield trial.note(KEPT.format(reason))
        return
    yield from _after_reset(trial, changed, first, drive, " with changed parameters")


def _after_reset(trial: Trial, used: First, first: First, drive: Excitation | None, how: str) -> Iterator[Problem]:
    """Reset an instance that has been used, and compare it with a new one."""
    used.fmu.reset()
    call = used.fmu.last
    used.fmu.initialise()
    input_ = first.inputs.difference(settings(used.fmu, "input"))
    parameter = first.parameters.difference(settings(used.fmu, "parameter"))
    between = difference(first.run, trial.simulate(used.fmu, COUNT, drive))
    back = f"a value is not back at its start after a run{how} and a reset"
    if input_ or (parameter and between):
        yield trial.error(f"{back}: {input_ or parameter}", call)
    elif parameter:
        yield trial.warning(f"{back}, which changes nothing in the run that follows: {parameter}", call)
    elif between:
        inputs = " with inputs that vary" if drive else ""
        yield trial.error(
            f"a run{inputs} after a run{how} and a reset differs from that of a new instance: {between}", call
        )
