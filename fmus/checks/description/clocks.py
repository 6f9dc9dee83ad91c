"""FMI 3: clocks and clocked variables."""

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.model import Variable, number, whole
from fmus.checks.problem import Problem

STAGE = "description"


def check(fmu: CheckedFmu) -> list[Problem]:
    """Clocks without interval, and variables whose clocks are none."""
    found = []
    for variable in fmu.model.variables if fmu.version == "3" else ():
        for word in (variable.clocks or "").split():
            clock = fmu.model.by_reference.get(whole(word))
            if clock is None or clock.type != "Clock":
                found.append(
                    fmu.error("clocks", f"names the clock {word}, which is no clock", variable.name, "", "2.4.7.4")
                )
        if variable.type == "Clock":
            found += [fmu.error("clocks", message, variable.name, "", "2.2.8.2") for message in _clock(variable)]
    return found


def _clock(clock: Variable) -> list[str]:
    get, said = clock.element.get, []
    variability = get("intervalVariability")
    if clock.causality in ("output", "local") and variability != "triggered":
        said.append(f"is an {clock.causality} clock with intervalVariability {variability}, which has to be triggered")
    if variability == "constant" and get("intervalDecimal") is None and get("intervalCounter") is None:
        said.append("has a constant interval, but gives none")
    if get("intervalDecimal") is not None and not number(get("intervalDecimal"), 0.0) > 0:
        said.append(f"intervalDecimal {get('intervalDecimal')} is not positive")
    if (get("intervalCounter") or get("supportsFraction") == "true") and get("resolution") is None:
        said.append("has an interval in counts, but no resolution")
    if clock.dimensions:
        said.append("is an array, which a clock cannot be")
    return said
