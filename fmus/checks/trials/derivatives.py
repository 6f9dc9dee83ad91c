"""Directional derivatives agree with differences (FMI 3: of each element of arrays)."""

from collections.abc import Iterator

import numpy as np

from fmus.checks.jacobian import Jacobian
from fmus.checks.problem import Problem
from fmus.checks.trial import Trial

PLACE, SEVERITY = 40, "error"
SHOWN = 5  # wrong derivatives that are listed


def applies(trial: Trial) -> bool:
    return trial.flag("providesDirectionalDerivative", "providesDirectionalDerivatives")


def run(trial: Trial) -> Iterator[Problem]:
    jacobian = Jacobian(trial)
    if not jacobian.unknowns or not jacobian.knowns:
        return
    wrong = 0
    for column in jacobian.columns():
        seed = np.zeros(trial.model.size(column.known))
        seed[column.element] = 1.0
        exact = jacobian.fmu.directional(jacobian.unknowns, column.known, seed)
        for k in np.flatnonzero(~(np.abs(exact - column.difference) <= column.uncertainty)):
            wrong += 1
            if wrong <= SHOWN:
                what = f"d {jacobian.names[k]} / d {column.known.name}"
                message = f"{what} is {exact[k]:g}, differences give {column.difference[k]:g}"
                yield trial.error(message, jacobian.fmu.last)
    if wrong > SHOWN:
        yield trial.error(f"{wrong - SHOWN} more directional derivatives differ from differences", jacobian.fmu.last)
