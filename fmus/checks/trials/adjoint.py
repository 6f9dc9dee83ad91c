"""FMI 3: adjoint derivatives agree with differences."""

from collections.abc import Iterator

import numpy as np

from fmus.checks.jacobian import Jacobian
from fmus.checks.problem import Problem
from fmus.checks.trial import Trial

PLACE, SEVERITY = 41, "error"


def applies(trial: Trial) -> bool:
    return trial.flag("", "providesAdjointDerivatives")


def run(trial: Trial) -> Iterator[Problem]:
    jacobian = Jacobian(trial)
    if not jacobian.unknowns or not jacobian.knowns:
        return
    columns = jacobian.columns()
    starts, place = {}, 0
    for known in jacobian.knowns:
        starts[id(known)], place = place, place + trial.model.size(known)
    for k, name in enumerate(jacobian.names[:200]):
        seed = np.zeros(len(jacobian.names))
        seed[k] = 1.0
        row = jacobian.fmu.adjoint(jacobian.unknowns, jacobian.knowns, seed)
        for column in columns:
            exact, given = row[starts[id(column.known)] + column.element], column.difference[k]
            if not abs(exact - given) <= column.uncertainty[k]:
                what = f"the adjoint derivative d {name} / d {column.known.name}"
                yield trial.error(f"{what} is {exact:g}, differences give {given:g}", jacobian.fmu.last)
                return
