"""A communication step that is not a number."""

import math
from collections.abc import Iterator

from fmus.checks.problem import Problem
from fmus.checks.provocation import provoke
from fmus.checks.settings import raw_step
from fmus.checks.trial import Trial

PLACE, SEVERITY = 86, "warning"


def applies(trial: Trial) -> bool:
    return trial.kind == "CoSimulation"


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.initialised()
    yield from provoke(trial, fmu, "a step that is not a number", lambda: raw_step(fmu, math.nan))
