"""Setting a fixed parameter after initialisation."""

from collections.abc import Iterator

from fmus.checks.model import Variable
from fmus.checks.problem import Problem
from fmus.checks.provocation import provoke
from fmus.checks.trial import Trial

PLACE, SEVERITY = 84, "warning"


def _fixed(trial: Trial) -> list[Variable]:
    return [
        v
        for v in trial.model.variables
        if v.causality == "parameter"
        and v.variability == "fixed"
        and v.type in ("Real", "Float64")
        and not v.dimensions
        and v.start
    ]


def applies(trial: Trial) -> bool:
    return bool(_fixed(trial))


def run(trial: Trial) -> Iterator[Problem]:
    fmu, given = trial.initialised(), _fixed(trial)[0]
    yield from provoke(
        trial,
        fmu,
        f"a fixed parameter after initialisation ({given.name})",
        lambda: fmu.set([given], [float(given.start or 0)], must=False),
    )
