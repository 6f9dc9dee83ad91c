"""An input that is not a number."""

import math
from collections.abc import Iterator

from fmus.checks.problem import Problem
from fmus.checks.provocation import provoke
from fmus.checks.settings import real_inputs
from fmus.checks.trial import Trial

PLACE, SEVERITY = 82, "warning"


def applies(trial: Trial) -> bool:
    return bool(real_inputs(trial.model))


def run(trial: Trial) -> Iterator[Problem]:
    fmu, given = trial.initialised(), real_inputs(trial.model)[0]
    yield from provoke(
        trial, fmu, f"an input that is not a number ({given.name})", lambda: fmu.set([given], [math.nan], must=False)
    )
