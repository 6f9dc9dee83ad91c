"""An input above its maximum."""

from collections.abc import Iterator

from fmus.checks.model import Variable
from fmus.checks.problem import Problem
from fmus.checks.provocation import provoke
from fmus.checks.settings import real_inputs
from fmus.checks.trial import Trial

PLACE, SEVERITY = 83, "warning"


def _bounded(trial: Trial) -> list[Variable]:
    return [v for v in real_inputs(trial.model) if abs(v.high) < 1e300]


def applies(trial: Trial) -> bool:
    return bool(_bounded(trial))


def run(trial: Trial) -> Iterator[Problem]:
    fmu, given = trial.initialised(), _bounded(trial)[0]
    yield from provoke(
        trial,
        fmu,
        f"an input above its maximum ({given.name})",
        lambda: fmu.set([given], [2 * abs(given.high) + 1], must=False),
    )
