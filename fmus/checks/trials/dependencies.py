"""An unknown does not change with a known that its list of dependencies leaves out."""

from collections.abc import Iterator

import numpy as np

from fmus.checks.jacobian import Jacobian
from fmus.checks.problem import Problem
from fmus.checks.trial import Trial

PLACE, SEVERITY = 42, "error"


def applies(trial: Trial) -> bool:
    lists = (*trial.model.outputs, *trial.model.derivatives, *trial.model.initial_unknowns)
    return any(unknown.dependencies is not None for unknown in lists)


def run(trial: Trial) -> Iterator[Problem]:
    jacobian = Jacobian(trial)
    if not jacobian.unknowns:
        return
    for column in jacobian.columns():
        # A change below the rounding of the differences is none.
        for k in np.flatnonzero(np.abs(column.difference) > np.maximum(column.uncertainty, 1e-6)):
            unknown = jacobian.owners[k]
            if unknown.dependencies is None or column.known is unknown.variable:  # a state that is an output itself
                continue
            if column.known not in map(trial.model.find, unknown.dependencies):
                yield trial.error(
                    f"{jacobian.names[k]} changes with {column.known.name}, which its dependencies leave out",
                    section=trial.section("2.2.8", "2.4.8"),
                )
                return
