"""Calls that the standard forbids to importers: an FMU should refuse them, and must be usable again after a reset.

An accepted call shows no violation, so that it is a warning; so is a crash in it.
"""

from collections.abc import Callable, Iterator

from fmus.checks.calls import DISCARD, ERROR, FATAL, CallFailedError, EndedError
from fmus.checks.instance import Instance
from fmus.checks.problem import Problem
from fmus.checks.trial import Trial


def provoke(trial: Trial, fmu: Instance, what: str, call: Callable[[], int]) -> Iterator[Problem]:
    """The problems of an FMU with a wrong call, as `what` names it: accepted, or unusable after a reset."""
    try:
        status = call()
    except EndedError:
        status = DISCARD
    except CallFailedError as failed:
        status = DISCARD if failed.call.status.endswith("Discard") else ERROR
    said = fmu.last
    if status < DISCARD:
        yield trial.warning(f"accepts {what}", said, trial.section("2.1.3", "2.2.4"))
    elif status >= FATAL:
        yield trial.warning(
            f"ends with {said.status} on {what}, so that no instance can be used any longer",
            said,
            trial.section("2.1.3", "2.2.4"),
        )
    elif status == ERROR:
        yield from _usable(trial, fmu, what)
    fmu.abandon()


def _usable(trial: Trial, fmu: Instance, what: str) -> Iterator[Problem]:
    """After an error the instance may be reset and used again (FMI 2.0.4, 2.1.3; FMI 3.0, 2.2.4)."""
    try:
        fmu.reset()
        fmu.initialise()
        trial.simulate(fmu, 2)
    except EndedError:
        pass
    except CallFailedError as failed:
        yield trial.warning(
            f"{failed.message}, after {what} was refused and the instance was reset",
            failed.call,
            trial.section("2.1.3", "2.2.4"),
        )
