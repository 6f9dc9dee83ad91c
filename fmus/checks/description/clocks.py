"""FMI 3: clocks, clocked variables and clocked states."""

from collections.abc import Iterator

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.model import Variable, number, whole
from fmus.checks.problem import Problem

STAGE = "description"
PERIODIC = ("constant", "fixed", "tunable")
VARIABLES, CLOCKS, TYPES = "2.4.7.4", "2.2.8.2", "2.4.4"  # sections of FMI 3.0


def check(fmu: CheckedFmu) -> list[Problem]:
    """Clocks without interval or priority, variables whose clocks are none, wrong clocked states."""
    if fmu.version != "3":
        return []
    found = [problem for variable in fmu.model.variables for problem in _problems(fmu, variable)]
    clocks = [v for v in fmu.model.variables if v.type == "Clock"]
    if clocks and "CoSimulation" in fmu.model.kinds and not fmu.model.flag("CoSimulation", "", "hasEventMode"):
        message = f"has the clock {clocks[0].name}, so that hasEventMode has to be true"
        found.append(fmu.error("clocks", message, "CoSimulation", "", "4.4"))
    return [*found, *_shared_previous(fmu)]


def _problems(fmu: CheckedFmu, variable: Variable) -> Iterator[Problem]:
    for section, messages in ((VARIABLES, _clocked(fmu, variable)), (VARIABLES, _previous(fmu, variable))):
        yield from (fmu.error("clocks", message, variable.name, "", section) for message in messages)
    if variable.type == "Clock":
        yield from (fmu.error("clocks", message, variable.name, "", CLOCKS) for message in _clock(variable))
        yield from (fmu.error("clocks", message, variable.name, "", TYPES) for message in _priority(fmu, variable))


def _clocked(fmu: CheckedFmu, variable: Variable) -> Iterator[str]:
    for word in (variable.clocks or "").split():
        clock = fmu.model.by_reference.get(whole(word))
        if clock is None or clock.type != "Clock":
            yield f"names the clock {word}, which is no clock"
    if variable.clocks and variable.type != "Clock" and variable.variability not in ("discrete", "tunable"):
        yield f"is a clocked variable with variability {variable.variability}, which has to be discrete or tunable"


def _previous(fmu: CheckedFmu, variable: Variable) -> Iterator[str]:
    if (word := variable.element.get("previous")) is None:
        return
    before = fmu.model.by_reference.get(whole(word))
    if variable.type == "Clock" or not variable.clocks or variable.variability != "discrete":
        yield "has the attribute previous, but is no discrete clocked variable"
    elif before is None:
        yield f"previous is {word}, which is no value reference of a variable"
    elif before is variable:
        yield "names itself as its previous value"
    elif before.type != variable.type or before.variability != "discrete" or before.causality == "input":
        yield f"has the previous value {before.name}, which is no discrete variable of type {variable.type} or an input"


def _shared_previous(fmu: CheckedFmu) -> Iterator[Problem]:
    first: dict[str, Variable] = {}
    for variable in fmu.model.variables:
        word = variable.element.get("previous")
        if word is not None and first.setdefault(word, variable) is not variable:
            message = f"has the previous value of {first[word].name}"
            yield fmu.error("clocks", message, variable.name, "", VARIABLES)


def _priority(fmu: CheckedFmu, clock: Variable) -> Iterator[str]:
    given, scheduled = clock.element.get("priority") is not None, "ScheduledExecution" in fmu.model.kinds
    if scheduled and clock.causality == "input" and not given:
        yield "is an input clock without priority, which scheduled execution requires"
    if clock.causality == "output" and given:
        yield "is an output clock with a priority, which it must not have"
    if scheduled and clock.causality == "local":
        yield "is a local clock, which scheduled execution does not permit"


def _clock(clock: Variable) -> list[str]:
    get, said = clock.element.get, []
    variability = get("intervalVariability")
    if clock.causality in ("output", "local") and variability != "triggered":
        said.append(f"is an {clock.causality} clock with intervalVariability {variability}, which has to be triggered")
    if variability == "constant" and get("intervalDecimal") is None and get("intervalCounter") is None:
        said.append("has a constant interval, but gives none")
    if get("intervalDecimal") is not None and not number(get("intervalDecimal"), 0.0) > 0:
        said.append(f"intervalDecimal {get('intervalDecimal')} is not positive")
    if get("intervalCounter") and get("resolution") is None:
        said.append("has an interval in counts, but no resolution")
    if variability not in PERIODIC and (get("intervalDecimal") or get("intervalCounter")):
        said.append(f"has an interval in the description, which a {variability} clock must not have")
    if clock.dimensions:
        said.append("is an array, which a clock cannot be")
    return said
