"""An FMU under test: FMI 2.0 and 3.0, model exchange and co-simulation under one set of names."""

import contextlib
from collections.abc import Callable, Iterator, Sequence
from ctypes import POINTER, c_double
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.model_description import ModelDescription

CLASSES = {("2", "CoSimulation"): FMU2Slave, ("2", "ModelExchange"): FMU2Model,
           ("3", "CoSimulation"): FMU3Slave, ("3", "ModelExchange"): FMU3Model}  # fmt: skip


class Subject:
    """One instance, initialised at its start values."""

    def __init__(self, description: ModelDescription, folder: str, kind: str):
        self.version, self.kind, self.description, self.folder = description.fmiVersion[0], kind, description, folder
        real = [v for v in description.modelVariables if v.type in ("Real", "Float64") and not v.dimensions]
        self.inputs = [v.valueReference for v in real if v.causality == "input" and v.variability == "continuous"]
        self.outputs = [v.valueReference for v in real if v.causality == "output"]
        rates = [u.variable for u in description.derivatives]
        exchange = kind == "ModelExchange"
        self.states = [v.derivative.valueReference for v in rates] if exchange else []
        self.unknowns = self.outputs + ([v.valueReference for v in rates] if exchange else [])
        self.knowns = self.inputs + self.states
        self.now = 0.0

    def name(self, reference: int) -> str:
        return next(v.name for v in self.description.modelVariables if v.valueReference == reference)

    # Life --------------------------------------------------------------------------------------------------

    def _instance(self, guid: str | None = None) -> Any:
        part = self.description.coSimulation if self.kind == "CoSimulation" else self.description.modelExchange
        fmu = CLASSES[self.version, self.kind](guid=guid or self.description.guid, unzipDirectory=self.folder,
                                               modelIdentifier=part.modelIdentifier, instanceName="check")  # fmt: skip
        fmu.instantiate(loggingOn=False)
        return fmu

    def open(self) -> None:
        self.fmu = self._instance()
        self._initialise()

    def reset(self) -> None:
        self.fmu.terminate()
        self.fmu.reset()
        self._initialise()

    def recover(self) -> None:
        """Reset after an error, when an FMU may not be terminated."""
        self.fmu.reset()
        self._initialise()

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()

    def _initialise(self) -> None:
        self.now = 0.0
        if self.version == "2":
            self.fmu.setupExperiment(startTime=0.0)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=0.0)
        self.fmu.exitInitializationMode()
        if self.kind == "ModelExchange":
            self._settle()

    def _settle(self) -> None:
        """Event iteration, then continuous time."""
        update = self.fmu.newDiscreteStates if self.version == "2" else self.fmu.updateDiscreteStates
        for _ in range(100):
            if not update()[0]:
                break
        self.fmu.enterContinuousTimeMode()

    # Values ------------------------------------------------------------------------------------------------

    def get(self, references: Sequence[int]) -> np.ndarray:
        read = self.fmu.getReal if self.version == "2" else self.fmu.getFloat64
        return np.array(read(references)) if references else np.zeros(0)

    def set(self, references: Sequence[int], values: Sequence[float]) -> None:
        write = self.fmu.setReal if self.version == "2" else self.fmu.setFloat64
        if references:
            write(references, values)

    def put(self, known: int, value: float) -> None:
        """Sets an input or, in model exchange, a state."""
        if known in self.inputs:
            self.set([known], [value])
            return
        states = self.get(self.states)
        states[self.states.index(known)] = value
        self._set_states(states)

    def _set_states(self, states: np.ndarray) -> None:
        if len(states):
            self.fmu.setContinuousStates(np.ascontiguousarray(states).ctypes.data_as(POINTER(c_double)), len(states))

    def scatter(self) -> None:
        """Inputs and states away from zero, where the bounds allow it."""
        for i, known in enumerate(self.knowns):
            with contextlib.suppress(FMICallException):
                self.put(known, self.get([known])[0] + 0.1 + 0.03 * (i % 7))

    # Time --------------------------------------------------------------------------------------------------

    def trajectory(self, steps: int, step: float) -> np.ndarray:
        """Outputs (steps + 1, ny); in model exchange by the explicit Euler method, which is reproducible."""
        rows = [self.get(self.outputs)]
        for _ in range(steps):
            if self.kind == "CoSimulation":
                self.fmu.doStep(self.now, step)
            elif self.states:
                rates = self.get(self.unknowns[len(self.outputs) :])
                self._set_states(self.get(self.states) + step * 1e-3 * rates)
            self.now += step
            if self.kind == "ModelExchange":
                self.fmu.setTime(self.now)
            rows.append(self.get(self.outputs))
        return np.array(rows)

    # State -------------------------------------------------------------------------------------------------

    def save(self) -> Any:
        self._saved_time = self.now
        return self.fmu.getFMUstate() if self.version == "2" else self.fmu.getFMUState()

    def restore(self, state: Any) -> None:
        self.now = self._saved_time
        (self.fmu.setFMUstate if self.version == "2" else self.fmu.setFMUState)(state)

    def free(self, state: Any) -> None:
        (self.fmu.freeFMUstate if self.version == "2" else self.fmu.freeFMUState)(state)

    def to_bytes(self, state: Any) -> bytes:
        return bytes((self.fmu.serializeFMUstate if self.version == "2" else self.fmu.serializeFMUState)(state))

    def from_bytes(self, data: bytes) -> Any:
        return (self.fmu.deSerializeFMUstate if self.version == "2" else self.fmu.deserializeFMUState)(data)

    def directional(self, known: int) -> list[float]:
        return self.fmu.getDirectionalDerivative(self.unknowns, [known], [1.0])

    # Misuse ------------------------------------------------------------------------------------------------

    def wrong_calls(self, step: float) -> Iterator[tuple[str, bool, bool]]:
        """(what was tried, whether it was refused, whether it must be refused); a correct FMU continues
        to work afterwards."""
        nowhere = 1 + max(v.valueReference for v in self.description.modelVariables)
        yield "a value reference that does not exist", refused(lambda: self.get([nowhere])), True
        if self.inputs:
            yield "an input that is not a number", refused(lambda: self.set(self.inputs[:1], [float("nan")])), False
        fixed = [v for v in self.description.modelVariables
                 if v.causality == "parameter" and v.variability == "fixed"
                 and v.type in ("Real", "Float64")]  # fmt: skip
        if fixed:
            yield (
                "a fixed parameter after initialisation",
                refused(lambda: self.set([fixed[0].valueReference], [float(fixed[0].start)])),
                True,
            )
        bounded = next(
            (
                v
                for v in self.description.modelVariables
                if v.causality == "input" and v.max is not None and v.valueReference in self.inputs
            ),
            None,
        )
        if bounded is not None:
            yield (
                "an input above its maximum",
                refused(lambda: self.set([bounded.valueReference], [2 * abs(float(bounded.max)) + 1])),
                False,
            )
        if self.kind == "CoSimulation":
            yield "a negative step", refused(lambda: self.fmu.doStep(self.now, -step)), True
            yield "a step that is not a number", refused(lambda: self.fmu.doStep(self.now, float("nan"))), False
        yield "a wrong identifier", refused(lambda: self._instance("{00000000-0000-0000-0000-000000000000}")), True


def refused(call: Callable[[], Any]) -> bool:
    try:
        call()
    except Exception:  # fmpy raises plain exceptions for an instance that is not made
        return True
    return False
