"""FMI 3: dimensions of array variables, and the number of start values of arrays and scalars."""

from fmus.checks.checked_fmu import CheckedFmu
from fmus.checks.model import LARGEST_ARRAY, Variable, whole
from fmus.checks.problem import Problem

STAGE = "description"


def check(fmu: CheckedFmu) -> list[Problem]:
    """Dimensions that name no size, and start values that do not fit."""
    if fmu.version != "3":
        return []
    return [problem for variable in fmu.model.variables for problem in _problems(fmu, variable)]


def _problems(fmu: CheckedFmu, variable: Variable) -> list[Problem]:
    said, sizes = [], []
    for start, reference in variable.dimensions:
        source = fmu.model.find(reference)
        if (start is None) == (reference is None):
            said.append("a dimension has to have either a start or a value reference")
        elif reference is not None and source is None:
            said.append(f"a dimension has the value reference {reference}, which no variable has")
        elif source is not None and (
            source.type != "UInt64"
            or not (source.causality == "structuralParameter" or source.variability == "constant")
        ):
            said.append(f"its dimension {source.name} is neither a structural parameter nor a constant of type UInt64")
        else:
            sizes.append(whole(start if source is None else source.start) or 0)
            if sizes[-1] < 1:
                said.append(f"a dimension has the start size {sizes[-1]}, it has to be positive")
    if variable.causality == "structuralParameter" and variable.dimensions:
        said.append("a structural parameter cannot have dimensions")
    if not said and variable.start is not None:
        count, size = _starts(variable), _product(sizes)
        if not variable.dimensions and count > 1:
            said.append(f"has {count} start values, but no dimension: a scalar has one")
        elif count not in (1, size) and variable.type not in ("String", "Binary"):
            said.append(f"has {count} start values for {size} elements")
    return [fmu.error("arrays", message, variable.name, "", "2.4.7.2") for message in said]


def _starts(variable: Variable) -> int:
    if variable.type in ("String", "Binary"):
        return len(variable.typed.findall("Start"))
    return len((variable.start or "").split())


def _product(sizes: list[int]) -> int:
    total = 1
    for size in sizes:
        total = min(total * size, LARGEST_ARRAY**2)
    return total
