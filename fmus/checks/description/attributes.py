"""Causality, variability, initial and start of each variable: the combinations that the standard permits."""

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.model import Variable
from fmus.checks.problem import Problem

STAGE = "description"
CALCULATED, ANY = ("calculated", "approx"), ("calculated", "exact", "approx")
# (causality, variability) -> values of `initial`; the versions differ in inputs and structural parameters only.
ALLOWED = {
    ("parameter", "fixed"): ("exact",), ("parameter", "tunable"): ("exact",),
    ("structuralParameter", "fixed"): ("exact",), ("structuralParameter", "tunable"): ("exact",),
    ("calculatedParameter", "fixed"): CALCULATED, ("calculatedParameter", "tunable"): CALCULATED,
    ("input", "discrete"): ("exact", None), ("input", "continuous"): ("exact", None),
    ("output", "constant"): ("exact",), ("output", "discrete"): ANY, ("output", "continuous"): ANY,
    ("local", "constant"): ("exact",), ("local", "fixed"): CALCULATED, ("local", "tunable"): CALCULATED,
    ("local", "discrete"): ANY, ("local", "continuous"): ANY, ("independent", "continuous"): (None,),
}  # fmt: skip
REALS = ("Real", "Float32", "Float64")


def check(fmu: CheckedFmu) -> list[Problem]:
    """Combinations that are not permitted."""
    found = [problem for variable in fmu.model.variables for problem in _problems(fmu, variable)]
    independent = sum(v.causality == "independent" for v in fmu.model.variables)
    if independent != 1 and (fmu.version == "3" or independent > 1):
        message = f"{independent} variables are independent, there has to be one"
        found.append(fmu.error("attributes", message, "ModelVariables", "2.2.7", "2.4.7.4"))
    default = [
        v.name
        for v in fmu.model.variables
        if fmu.version == "2" and v.type != "Real" and not v.element.get("variability")
    ]
    if default:
        some = f"{len(default)} variable{'s that are' if len(default) > 1 else ' that is'} not real"
        message = f"{some} without variability, the first is {default[0]}; the default, continuous, is for reals only"
        found.append(fmu.warning("attributes", message, "ModelVariables", "2.2.7"))
    return found


def _problems(fmu: CheckedFmu, v: Variable) -> list[Problem]:
    said = []
    given = v.element.get("initial")
    allowed = ALLOWED.get((v.causality, v.variability))
    if v.variability == "continuous" and v.type not in REALS:
        said.append(f"a variable of type {v.type} cannot be continuous")
    if v.type == "Clock":
        if v.causality not in ("input", "output", "local"):
            said.append(f"a clock cannot have causality {v.causality}")
    elif allowed is None:
        said.append(f"causality {v.causality} with variability {v.variability} is not permitted")
    elif (given if given is not None else v.initial) not in allowed or (
        given is not None and (v.causality == "input" and fmu.version == "2")
    ):
        said.append(f"initial {given!r} is not permitted for causality {v.causality} with variability {v.variability}")
    elif v.start is None and (v.initial in ("exact", "approx") or v.causality == "input"):
        said.append("has no start value")
    elif v.start is not None and (v.initial == "calculated" or v.causality == "independent"):
        said.append(
            "has a start value, which is not permitted for "
            + ("an independent variable" if v.causality == "independent" else "initial calculated")
        )
    return [fmu.error("attributes", message, v.name, "2.2.7", "2.4.7.4") for message in said]
