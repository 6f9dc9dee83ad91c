"""Variables that an importer sets, their start values, and steps whose status is looked at."""

import numpy as np

from fmus.checks.instance import Instance
from fmus.checks.model import FLOATS, Model, Variable

TRUTH = {"true": 1, "false": 0}


def real_inputs(model: Model) -> list[Variable]:
    """Scalar continuous inputs of double precision."""
    return [
        v
        for v in model.variables
        if v.causality == "input"
        and v.variability == "continuous"
        and v.type in ("Real", "Float64")
        and not v.dimensions
        and not v.clocks
        and v.reference is not None
    ]


def raw_step(fmu: Instance, step: float) -> int:
    """The status of a communication step [s], whatever it is."""
    if fmu.version == "2":
        return fmu.attempt("DoStep", fmu.time, step, 0)
    flags = fmu.ffi.new("bool[3]")
    return fmu.attempt("DoStep", fmu.time, step, False, flags, flags + 1, flags + 2, fmu.ffi.new("double *"))


def start_values(variable: Variable, size: int) -> np.ndarray | None:
    """Start values of the description (size,); one value stands for all elements. None where there are none."""
    convert = float if variable.type in FLOATS else int
    try:
        words = [TRUTH.get(word, word) for word in (variable.start or "").split()]
        found = np.array([convert(word) for word in words])
    except ValueError:
        return None
    return np.full(size, found[0]) if len(found) == 1 else found if len(found) == size > 0 else None


def start_data(variable: Variable, size: int) -> list[bytes] | None:
    """Start values of a string or binary variable, `size` of them; one stands for all elements. None where the
    description has none that can be read."""
    given = [child.get("value") or "" for child in variable.typed.findall("Start")] or [variable.start or ""]
    try:
        found = [bytes.fromhex(text) if variable.type == "Binary" else text.encode() for text in given]
    except ValueError:
        return None
    return found * size if len(found) == 1 else found if len(found) == size else None


def set_start(fmu: Instance, variables: list[Variable]) -> None:
    """Set variables to the start values of the description. Raises CallFailedError."""
    for variable in variables:
        size = fmu.model.size(variable)
        if variable.type in ("String", "Binary"):
            if (data := start_data(variable, size)) is not None:
                (fmu.set_texts if variable.type == "String" else fmu.set_binaries)([variable], data)
        elif (values := start_values(variable, size)) is not None:
            fmu.set([variable], values)
