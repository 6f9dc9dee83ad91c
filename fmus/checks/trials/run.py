"""A simulation of the default experiment from the start values: every call succeeds, every number is finite. The time
of the FMU itself may differ from the communication points (FMI 3.0, 4.2.1), by less than a step of either."""

from collections.abc import Iterator

import numpy as np

from fmus.checks.instance import TINY, Instance
from fmus.checks.model import number
from fmus.checks.problem import Problem
from fmus.checks.simulation import Run, step_size
from fmus.checks.trial import Trial

PLACE, SEVERITY = 2, "error"


def applies(trial: Trial) -> bool:
    return True


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.initialised()
    found = trial.simulate(fmu)
    bad = np.argwhere(~np.isfinite(found.values))
    if len(bad):
        row, column = bad[0]
        what = f"{found.names[column]} is {found.values[row, column]:g} at {found.times[row]:g} s"
        yield trial.error(f"{what} in a run from the start values", fmu.last, trial.section("2.1.7", "2.2.7.2"))
    yield from _texts(trial, fmu, found)
    yield from _own_time(trial, fmu, found)
    if found.ended:
        yield trial.note(f"the FMU asks for the end of the simulation at {fmu.time:g} s")


def _texts(trial: Trial, fmu: Instance, found: Run) -> Iterator[Problem]:
    strings = {v.name for v in trial.model.variables if v.type == "String"}
    for when, row in zip(found.times, found.data, strict=True):
        for name, data in zip(found.data_names, row, strict=True):
            if name in strings and data.decode("utf-8", "ignore").encode() != data:
                what = f"{name} is not UTF-8 at {when:g} s"
                yield trial.error(f"{what} in a run from the start values", fmu.last, trial.section("2.1.2", "2.2.3"))
                return


def _own_time(trial: Trial, fmu: Instance, found: Run) -> Iterator[Problem]:
    element = trial.model.root.find(trial.kind)
    internal = number(None if element is None else element.get("fixedInternalStepSize"), 0.0)
    most = max(step_size(trial.model, trial.kind), internal) * (1 + TINY)
    if not found.ended and not fmu.exchange and abs(fmu.internal_time - fmu.time) > most:
        what = f"the FMU's own time is {fmu.internal_time:g} s at the communication point {fmu.time:g} s"
        yield trial.warning(f"{what}, more than a step away", fmu.last)
