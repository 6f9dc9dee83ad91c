"""FMI 3, co-simulation: intermediate updates within a step. Their times lie in the step and do not go back behind a
finished one; variables can be accessed there; the FMU returns early only where the importer has allowed it."""

from collections.abc import Iterator

from fmus.checks.callbacks import Callbacks, Update
from fmus.checks.instance import TINY, Instance
from fmus.checks.model import Variable
from fmus.checks.problem import Problem
from fmus.checks.simulation import Run
from fmus.checks.trial import Trial

PLACE, SEVERITY = 64, "error"
STEPS = 50


def applies(trial: Trial) -> bool:
    return trial.kind == "CoSimulation" and trial.flag("", "providesIntermediateUpdate")


def run(trial: Trial) -> Iterator[Problem]:
    seen: list[tuple[float, Update]] = []  # with the communication point of the step
    variables = _accessible(trial)

    def look(update: Update) -> bool:
        seen.append((fmu.time, update))
        if update.readable and (outputs := [v for v in variables if v.causality != "input"]):
            fmu.floats(outputs)
        if update.settable:
            for variable in (v for v in variables if v.causality == "input"):
                fmu.set([variable], held[variable.name])
        return False

    fmu = trial.instance(callbacks=Callbacks(variables, on_update=look))
    fmu.initialise()
    held = {v.name: fmu.get([v]) for v in variables if v.causality == "input"}
    found = trial.simulate(fmu, STEPS)
    fmu.callbacks.settle()
    yield from _order(trial, fmu, seen, found)


def _accessible(trial: Trial) -> list[Variable]:
    """The real inputs and outputs that can be accessed in an update."""
    real = [v for v in trial.model.variables if v.real and v.causality in ("input", "output") and trial.model.size(v)]
    return [v for v in real if v.element.get("intermediateUpdate") in ("true", "1") and v.reference is not None]


def _order(trial: Trial, fmu: Instance, seen: list[tuple[float, Update]], found: Run) -> Iterator[Problem]:
    section = trial.section("", "4.2.1")
    if not seen:
        steps = f"{len(found.rows) - 1} step{'s' * (len(found.rows) != 2)}"
        yield trial.warning(f"calls no intermediate update in {steps}, which it says that it provides", section=section)
    finished = fmu.start
    ends = dict(zip(found.times, found.times[1:], strict=False))
    for point, update in seen:
        end = ends.get(point, fmu.time)
        slack = TINY * max(1.0, abs(end))
        if not point - slack <= update.time <= end + slack:
            what = f"outside of the step from {point:g} s to {end:g} s"
            yield trial.error(f"calls an intermediate update at {update.time:g} s, {what}", section=section)
            return
        if update.time < finished - slack:
            what = f"before a finished one at {finished:g} s"
            yield trial.error(f"calls an intermediate update at {update.time:g} s, {what}", section=section)
            return
        if update.finished:
            finished = update.time
    if any(u.can_return for _, u in seen) and not trial.flag("", "canReturnEarlyAfterIntermediateUpdate"):
        what = "though canReturnEarlyAfterIntermediateUpdate is not true"
        yield trial.warning(f"offers an early return in an intermediate update, {what}", section=section)
