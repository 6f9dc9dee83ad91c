"""With inputs that vary and parameters off their start values: a restored state has the inputs, the parameters and the
internal memory of the saved one, and so has a state read from bytes."""

import math
from collections.abc import Iterator

import numpy as np

from fmus.checks.excitation import (
    KEPT,
    SECONDS,
    Excitation,
    NotAcceptedError,
    Settings,
    accepted_run,
    changed_parameters,
    first_run,
    put,
    settings,
    start_parameters,
)
from fmus.checks.instance import Instance
from fmus.checks.problem import Problem
from fmus.checks.simulation import SAME, Run, difference, recorded, values
from fmus.checks.trial import Trial

PLACE, SEVERITY = 31, "error"
PLACES = (3, 12)  # communication steps before the saved state: one while the inputs move away, one while they return
AFTER = 40  # communication steps after it
LOOSE = 1e-4  # of a value: what a solver of an FMU for co-simulation may differ by, where no tolerance is stated


def applies(trial: Trial) -> bool:
    saves = trial.flag("canGetAndSetFMUstate", "canGetAndSetFMUState")
    return saves and (bool(Excitation(trial)) or bool(changed_parameters(trial)))


def run(trial: Trial) -> Iterator[Problem]:
    trial.seconds = SECONDS
    first, notes = accepted_run(trial, max(PLACES) + AFTER)
    first.fmu.close()
    yield from notes
    drive = first.drive
    for before in PLACES:
        problems = list(_inputs(trial, drive, before)) if drive else []
        yield from problems
        if problems:
            break
    if changed_parameters(trial):
        yield from _parameters(trial, drive)


def _inputs(trial: Trial, drive: Excitation, before: int) -> Iterator[Problem]:
    fmu = trial.initialised()
    if trial.simulate(fmu, before, drive).ended:
        fmu.close()
        return
    saved, at_saving = fmu.save(), _now(fmu)
    first = trial.simulate(fmu, AFTER, drive)
    if not first.ended:
        fmu.restore(saved)
        problems = list(_compare(trial, fmu, at_saving, first, "a state was restored", drive))
        yield from problems
        if not problems and trial.flag("canSerializeFMUstate", "canSerializeFMUState"):
            copy = fmu.from_bytes(fmu.to_bytes(saved), saved)
            fmu.restore(copy)
            yield from _compare(trial, fmu, at_saving, first, "a state was read from bytes and restored", drive)
            fmu.free_state(copy)
        fmu.free_state(saved)
    fmu.close()


def _parameters(trial: Trial, drive: Excitation | None) -> Iterator[Problem]:
    """In initialisation mode the standard permits both to set parameters and to save and restore the state."""
    changed = changed_parameters(trial)
    try:
        first = first_run(trial, AFTER, drive, changed)
    except NotAcceptedError as reason:
        yield trial.note(KEPT.format(reason))
        return
    first.fmu.close()
    fmu = trial.instance()
    fmu.enter_initialisation()
    put(fmu, changed)
    saved = fmu.save()
    put(fmu, start_parameters(trial))
    fmu.restore(saved)
    call = fmu.last
    fmu.exit_initialisation()
    inputs, parameters = settings(fmu, "input"), settings(fmu, "parameter")
    if differs := first.inputs.difference(inputs) or first.parameters.difference(parameters):
        yield trial.error(f"values after a state was restored differ from those when it was saved: {differs}", call)
    elif differs := difference(first.run, trial.simulate(fmu, AFTER, drive), _same(trial)):
        what = "a run after a state with changed parameters was restored differs from a run with these parameters"
        yield trial.error(f"{what}: {differs}", call)
    fmu.free_state(saved)


def _now(fmu: Instance) -> Settings:
    """The inputs, parameters and recorded variables."""
    found, variables = settings(fmu, "input", "parameter"), recorded(fmu.model)
    names = [v.name for v in variables for _ in range(fmu.model.size(v))]
    return Settings([*found.names, *names], np.concatenate([found.values, values(fmu, variables)]))


def _compare(
    trial: Trial, fmu: Instance, at_saving: Settings, first: Run, after: str, drive: Excitation
) -> Iterator[Problem]:
    call = fmu.last
    if differs := at_saving.difference(_now(fmu)):
        yield trial.error(f"values after {after} differ from those when it was saved: {differs}", call)
    elif differs := difference(first, trial.simulate(fmu, AFTER, drive), _same(trial)):
        yield trial.error(
            f"steps with inputs that vary after {after} differ from those after it was saved: {differs}", call
        )


def _same(trial: Trial) -> float:
    """The relative deviation of equal runs. A solver that starts anew at the saved state is within its tolerance."""
    if trial.kind == "ModelExchange":
        return SAME
    tolerance = trial.model.experiment("tolerance")
    return max(10 * tolerance, SAME) if math.isfinite(tolerance) and tolerance > 0 else LOOSE
