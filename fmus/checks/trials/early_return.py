"""FMI 3, co-simulation: early return from a step, of the FMU's own accord and where an intermediate update asks for it.
The next step goes on from the time that was reached."""

from collections.abc import Iterator

from fmus.checks.callbacks import Callbacks, Update
from fmus.checks.instance import TINY
from fmus.checks.problem import Problem
from fmus.checks.simulation import step_size
from fmus.checks.trial import Trial

PLACE, SEVERITY = 65, "error"
OWN, ASKED = 50, 10  # communication steps
ON_REQUEST = "canReturnEarlyAfterIntermediateUpdate"


def applies(trial: Trial) -> bool:
    return trial.kind == "CoSimulation" and (trial.flag("", "mightReturnEarlyFromDoStep") or trial.flag("", ON_REQUEST))


def run(trial: Trial) -> Iterator[Problem]:
    fmu = trial.instance(callbacks=Callbacks(early_return=True))
    fmu.initialise()
    for _ in trial.steps(fmu, OWN):
        if fmu.early and not trial.flag("", "mightReturnEarlyFromDoStep"):
            what = "which mightReturnEarlyFromDoStep does not say"
            yield trial.error(f"returns early at {fmu.time:g} s, {what}", fmu.last, trial.section("", "4.4"))
            break
    if trial.flag("", ON_REQUEST):
        yield from _on_request(trial)


def _on_request(trial: Trial) -> Iterator[Problem]:
    """Ask in every second step for a return at the first update after its beginning that offers one."""
    requests: list[float] = []

    def ask(update: Update) -> bool:
        inside = fmu.time + TINY < update.time < fmu.time + step - TINY
        wanted = asking and not requests and update.can_return and update.finished and inside
        if wanted:
            requests.append(update.time)
        return wanted

    fmu, step = (
        trial.instance(callbacks=Callbacks(early_return=True, on_update=ask)),
        step_size(trial.model, trial.kind),
    )
    fmu.initialise()
    made = kept = 0
    asking = True
    for _ in trial.steps(fmu, ASKED):
        fmu.callbacks.settle()
        if requests and fmu.early and fmu.time < requests[0] - TINY * max(1.0, abs(fmu.time)):
            what = f"before the time {requests[0]:g} s that was asked for"
            yield trial.error(f"returns early at {fmu.time:g} s, {what}", fmu.last, trial.section("", "4.2.1"))
            return
        made, kept, asking = made + bool(requests), kept + bool(requests and fmu.early), not asking
        requests.clear()
    if made and not kept:
        what = f"but returned early in none of {made} step{'s' * (made > 1)} that asked for it"
        yield trial.warning(f"offers an early return, {what}", section=trial.section("", "4.2.1"))
