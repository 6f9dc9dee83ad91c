"""An instance with another GUID (FMI 2) or instantiation token (FMI 3) than that of the description."""

from collections.abc import Iterator

from fmus.checks.calls import CallFailedError
from fmus.checks.problem import Problem
from fmus.checks.trial import Trial

PLACE, SEVERITY = 80, "warning"
WRONG = "{00000000-0000-0000-0000-000000000000}"


def applies(trial: Trial) -> bool:
    return bool(trial.model.token) and trial.model.token != WRONG


def run(trial: Trial) -> Iterator[Problem]:
    try:
        fmu = trial.instance(WRONG)
    except CallFailedError:
        return
    what = "GUID" if trial.model.version == "2" else "instantiation token"
    yield trial.warning(
        f"accepts a wrong {what}, so that a description of another FMU goes unnoticed",
        fmu.last,
        trial.section("2.1.5", "2.3.1"),
    )
    fmu.abandon()
