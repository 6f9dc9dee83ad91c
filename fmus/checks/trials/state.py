"""Steps after a restored state repeat those after the saved one, and so do they after a state read from bytes."""

from collections.abc import Iterator

import numpy as np

from fmus.checks.instance import Instance, SavedState
from fmus.checks.problem import Problem
from fmus.checks.simulation import Run, difference, recorded, values
from fmus.checks.trial import Trial

PLACE, SEVERITY = 30, "error"
BEFORE, AFTER = 5, 20  # communication steps before and after the saved state


def applies(trial: Trial) -> bool:
    return trial.flag("canGetAndSetFMUstate", "canGetAndSetFMUState")


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.initialised()
    if trial.simulate(fmu, BEFORE).ended:
        return
    saved, at_saving = fmu.save(), _now(fmu)
    first = trial.simulate(fmu, AFTER)
    if first.ended:
        return
    fmu.restore(saved)
    yield from _compare(trial, fmu, at_saving, first, "a state was restored")
    if trial.flag("canSerializeFMUstate", "canSerializeFMUState"):
        yield from _serialised(trial, fmu, saved, at_saving, first)
    fmu.free_state(saved)


def _now(fmu: Instance) -> np.ndarray:
    return values(fmu, recorded(fmu.model))


def _compare(trial: Trial, fmu: Instance, at_saving: np.ndarray, first: Run, after: str) -> Iterator[Problem]:
    call = fmu.last
    if not np.allclose(_now(fmu), at_saving, rtol=1e-9, atol=0, equal_nan=True):
        yield trial.error(f"values after {after} differ from those when it was saved", call)
    elif differs := difference(first, trial.simulate(fmu, AFTER)):
        yield trial.error(f"steps after {after} differ from those after it was saved: {differs}", call)


def _serialised(trial: Trial, fmu: Instance, saved: SavedState, at_saving: np.ndarray, first: Run) -> Iterator[Problem]:
    data = fmu.to_bytes(saved)
    copy = fmu.from_bytes(data, saved)
    if fmu.to_bytes(copy) != data:
        yield trial.warning("a state written to bytes, read and written again gives other bytes", fmu.last)
    fmu.restore(copy)
    yield from _compare(trial, fmu, at_saving, first, "a state was read from bytes and restored")
    fmu.free_state(copy)
