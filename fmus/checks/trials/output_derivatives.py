"""Co-simulation: derivatives of continuous outputs up to the order that the description states."""

from collections.abc import Iterator

import numpy as np

from fmus.checks.model import whole
from fmus.checks.problem import Problem
from fmus.checks.trial import Trial

PLACE, SEVERITY = 61, "error"


def _order(trial: Trial) -> int:
    return whole(trial.model.root.find(trial.kind).get("maxOutputDerivativeOrder")) or 0  # type: ignore[union-attr]


def applies(trial: Trial) -> bool:
    return trial.kind == "CoSimulation" and _order(trial) > 0


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.initialised()
    if trial.simulate(fmu, 3).ended:
        return
    outputs = [
        u.variable
        for u in trial.model.outputs
        if u.variable is not None
        and u.variable.type in ("Real", "Float64")
        and u.variable.variability == "continuous"
        and not u.variable.dimensions
    ]
    for order in range(1, _order(trial) + 1) if outputs else ():
        orders, values = (
            fmu.ffi.new("int[]" if trial.model.version == "2" else "int32_t[]", [order] * len(outputs)),
            np.full(len(outputs), np.nan),
        )
        buffer = fmu.ffi.from_buffer("double[]", values)
        name = "GetRealOutputDerivatives" if trial.model.version == "2" else "GetOutputDerivatives"
        fmu.call(name, fmu.references(outputs), len(outputs), orders, buffer, *fmu.count(len(outputs)))
        if not np.isfinite(values).all():
            k = int(np.argmin(np.isfinite(values)))
            yield trial.error(f"derivative {order} of {outputs[k].name} is {values[k]:g}", fmu.last)
