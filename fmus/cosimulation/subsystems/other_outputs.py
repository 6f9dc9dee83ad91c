"""Outputs of an FMU that are no scalars of type Real or Float64, as numbers: for the rows of a single FMU.

A Boolean is 0 or 1, an enumeration the number of its item. An array has a column for each element, `y[1]` or `y[1][2]`.
Each read converts lists, which takes longer than that of `FmuInstance.exchange`.
"""

from collections.abc import Mapping

import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.model_description import ModelVariable

from fmus.cosimulation.subsystems.fmu_instance import FmuInstance
from fmus.cosimulation.subsystems.typed_values import REAL

INTEGERS = [f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)]
# The method of fmpy that reads a variable, by the version of FMI and the type of the variable
GETTERS: Mapping[int, Mapping[str, str]] = {
    2: {"Integer": "getInteger", "Enumeration": "getInteger", "Boolean": "getBoolean"},
    3: {**{kind: f"get{kind}" for kind in (*INTEGERS, "Float32", "Float64", "Boolean")}, "Enumeration": "getInt64"},
}


class OtherOutputs:
    """The outputs of an instance that `FmuInstance.outputs` does not have.

    names (n,) are those of the columns, variables (n,) those of the FMU. notes are sentences on the inputs and outputs
    that have no column.
    """

    def __init__(self, fmu: FmuInstance):
        self._fmu = fmu
        getters = GETTERS[fmu.calls.version]
        outside = [v for v in fmu.description.modelVariables if v.type not in REAL or v.dimensions]
        outputs = [v for v in outside if v.causality == "output"]
        readable = [v for v in outputs if v.type in getters]
        elements = [(v, name) for v in readable for name in _elements(v)]
        self.names = tuple(name for _, name in elements)
        self.variables = tuple(v.name for v, _ in elements)
        self._groups: list[tuple[str, list[int], np.ndarray]] = []  # getter, references, places of the values
        for kind in dict.fromkeys(v.type for v in readable):
            places = np.array([k for k, (v, _) in enumerate(elements) if v.type == kind], int)
            self._groups.append((getters[kind], [v.valueReference for v in readable if v.type == kind], places))
        self.notes = _notes(
            [v for v in outside if v.causality == "input"], [v for v in outputs if v.type not in getters]
        )

    def read(self) -> np.ndarray:
        """The present values (n,). Raises SimulationError where the FMU refuses."""
        found = np.zeros(len(self.names))
        for getter, references, places in self._groups:
            sized = (len(places),) if self._fmu.calls.version > 2 else ()
            try:
                found[places] = getattr(self._fmu.calls.fmu, getter)(references, *sized)
            except FMICallException as error:
                self._fmu.calls.fail(error.function, error.status)
        return found


def _elements(variable: ModelVariable) -> list[str]:
    """The names of the elements of an array, the last index first to change; of a scalar, its name."""
    return [variable.name + "".join(f"[{k + 1}]" for k in place) for place in np.ndindex(*(variable.shape or ()))]


def _notes(inputs: list[ModelVariable], outputs: list[ModelVariable]) -> tuple[str, ...]:
    notes = []
    if inputs:
        notes.append(f"inputs without a column, which keep their value: {_listed(inputs)}; only a scalar of type Real "
                     "or Float64 can be an input over time")  # fmt: skip
    if outputs:
        notes.append(f"outputs without a column: {_listed(outputs)}; only numbers, Booleans and enumerations are "
                     "written")  # fmt: skip
    return tuple(notes)


def _listed(variables: list[ModelVariable]) -> str:
    return ", ".join(f"{v.name} ({'array of ' if v.dimensions else ''}{v.type})" for v in variables)
