"""The FMI functions that a master calls, of FMI 2.0 and 3.0 under one set of names, on preallocated arrays.

fmpy loads the library. Its wrappers convert every list in every call, which costs more than a step of a small FMU, so
the functions are called with the addresses of arrays. A status other than OK or warning becomes a SimulationError with
the FMU's last message.
"""

from collections.abc import Callable, Mapping, Sequence
from ctypes import CFUNCTYPE, byref, c_bool, c_double, c_int, c_size_t, c_uint, c_void_p, cast
from typing import Any, ClassVar

import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, calloc, fmi2CallbackFunctions, free
from fmpy.fmi2 import fmi2CallbackAllocateMemoryTYPE as Allocate
from fmpy.fmi2 import fmi2CallbackFreeMemoryTYPE as Free
from fmpy.fmi2 import fmi2CallbackLoggerTYPE as Logger
from fmpy.fmi3 import FMU3Slave, fmi3IntermediateUpdateCallback, fmi3LogMessageCallback
from fmpy.model_description import ModelVariable

from fmus.cosimulation.master.library import address, array, library, pointer, structures
from fmus.cosimulation.subsystems.typed_values import Value, typed
from fmus.support.errors import EndRequestedError, MissingToolError, SimulationError, StepTooLongError

Call = Callable[..., None]

WARNING, DISCARD, FATAL = 1, 2, 4
STATUSES = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")  # by number, after fmi2 or fmi3
LAST_SUCCESSFUL_TIME, TERMINATED = 2, 3  # kinds of status of FMI 2.0


class Calls:
    """One co-simulation instance. References, orders and values are addresses of uint32, int32 and float64 arrays."""

    set: Call  # references, count, values
    get: Call
    step: Call  # time, step
    get_slopes: Call  # references, count, orders, values
    set_slopes: Call | None = None
    restore: Call  # state
    reset: Call
    directional: Call  # unknowns, their count, knowns, their count, seed, result
    _save: Call
    _free: Call

    path: Any = None  # the Path of structures.h: how the inputs move within a step, where the FMU asks for them
    version: int
    setters: ClassVar[Mapping[str, str]]  # the method of fmpy that sets a variable, by the variable's type
    functions: tuple[str, ...]  # of the library, in the order of structures.h

    def __init__(self, fmu: Any, name: str):
        self.fmu, self.name, self.said, self.alive = fmu, name, "", True

    def start(self, time: float) -> None:
        """Initialise. Raises SimulationError when the FMU does not."""
        try:
            self._enter_initialisation(time)
            self.fmu.exitInitializationMode()
        except FMICallException as error:
            self.fail(error.function, error.status)

    def _enter_initialisation(self, time: float) -> None:
        raise NotImplementedError

    def move(self, coefficients: np.ndarray, time: float, step: float) -> None:
        """In the next step, from `time`, the inputs are polynomials with coefficients (4, nu) in
        powers of time / step."""
        raise NotImplementedError

    def set_typed(self, variable: ModelVariable, value: Value) -> None:
        """Set a variable that is no Real or Float64. Raises SimulationError where the FMU refuses it."""
        if variable.type not in self.setters or variable.dimensions:
            kind = "an array" if variable.dimensions else f"of type {variable.type}"
            raise SimulationError(f"{self.name}: {variable.name} is {kind}, which cannot be set here")
        try:
            set_one = getattr(self.fmu, self.setters[variable.type])
            set_one([variable.valueReference], [typed(variable, value)])
        except FMICallException as error:
            self.fail(error.function, error.status)

    def save(self, state: c_void_p) -> None:
        """Save into a state, which is made where it is null."""
        self._save(byref(state))

    def free(self, state: c_void_p) -> None:
        self._free(byref(state))

    def function(self, name: str, *arguments: Any) -> Call:
        """A function of the library that takes the instance first and returns a status."""
        found = CFUNCTYPE(c_int, c_void_p, *arguments)((name, self.fmu.dll))
        instance = self.fmu.component

        def call(*values: Any) -> None:
            status = found(instance, *values)
            if status > WARNING:
                self.fail(name, status)

        return call

    def fail(self, name: str, status: int) -> None:
        said, self.said = self.said, ""
        self.alive = status < FATAL
        known = 0 <= status < len(STATUSES)
        shown = f"fmi{self.version}{STATUSES[status]}" if known else f"{status}, which the standard does not have"
        kind = StepTooLongError if status == DISCARD and name.endswith("DoStep") else SimulationError
        raise kind(f"{self.name}: {name} failed with status {shown}{': ' + said if said else ''}")

    def listen(self, status: int, message: bytes | None) -> None:
        if status > WARNING and message:
            self.said = message.decode(errors="replace")

    def close(self) -> None:
        """Free the instance, except after a fatal status, when the standard forbids it."""
        if self.alive:
            self.alive = False
            self.fmu.freeInstance()


class Calls2(Calls):
    """FMI 2.0."""

    version = 2
    setters: ClassVar = {"Integer": "setInteger", "Enumeration": "setInteger", "Boolean": "setBoolean",
                         "String": "setString"}  # fmt: skip
    functions = ("fmi2SetReal", "fmi2GetReal", "fmi2DoStep", "fmi2SetRealInputDerivatives",
                 "fmi2GetRealOutputDerivatives",
                 "fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2GetDirectionalDerivative")  # fmt: skip

    def __init__(self, name: str, files: Mapping[str, str], moving: Sequence[int] = ()):
        super().__init__(FMU2Slave(instanceName=name, **files), name)
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = Logger(lambda environment, instance, status, category, message: self.listen(status, message))
        callbacks.allocateMemory, callbacks.freeMemory = Allocate(calloc), Free(free)
        try:
            self.fmu.instantiate(callbacks=callbacks, loggingOn=True)
        except Exception:  # fmpy raises a plain exception without the FMU's message
            if not self.said:
                raise
            raise SimulationError(f"fmi2Instantiate failed: {self.said}") from None
        array, count, state = c_void_p, c_size_t, c_void_p
        self.set = self.function("fmi2SetReal", array, count, array)
        self.get = self.function("fmi2GetReal", array, count, array)
        step = self.function("fmi2DoStep", c_double, c_double, c_int)
        self.step = lambda time, size: step(time, size, 0)
        self.set_slopes = self.function("fmi2SetRealInputDerivatives", array, count, array, array)
        self.get_slopes = self.function("fmi2GetRealOutputDerivatives", array, count, array, array)
        self._save = self.function("fmi2GetFMUstate", state)
        self.restore = self.function("fmi2SetFMUstate", state)
        self._free = self.function("fmi2FreeFMUstate", state)
        self.reset = self.function("fmi2Reset")
        self.directional = self.function("fmi2GetDirectionalDerivative", array, count, array, count, array, array)

    def fail(self, name: str, status: int) -> None:
        if name == "fmi2DoStep" and status == DISCARD:
            self._raise_if_ended()
        super().fail(name, status)

    def _raise_if_ended(self) -> None:
        """Raises EndRequestedError where the FMU has discarded a step in order to end the simulation."""
        try:
            ended = self.fmu.getBooleanStatus(TERMINATED)
            time = self.fmu.getRealStatus(LAST_SUCCESSFUL_TIME)
        except FMICallException:
            return
        if ended:
            raise EndRequestedError(self.name, float(getattr(time, "value", time)))

    def _enter_initialisation(self, time: float) -> None:
        self.fmu.setupExperiment(startTime=time)
        self.fmu.enterInitializationMode()


class Calls3(Calls):
    """FMI 3.0. Every array of values is passed with its length. Inputs have no derivatives: the FMU
    requests inputs within a step.

    moving are the references of the inputs that vary within a step, all of them or none.
    """

    version = 3
    setters: ClassVar = {**{f"{sign}Int{bits}": f"set{sign}Int{bits}"
                            for sign in ("", "U") for bits in (8, 16, 32, 64)},
               "Enumeration": "setInt64", "Boolean": "setBoolean", "String": "setString",
               "Float32": "setFloat32"}  # fmt: skip
    functions = ("fmi3SetFloat64", "fmi3GetFloat64", "fmi3DoStep", "", "",
                 "fmi3GetFMUState", "fmi3SetFMUState", "fmi3GetDirectionalDerivative")  # fmt: skip

    def __init__(self, name: str, files: Mapping[str, str], moving: Sequence[int] = ()):
        super().__init__(FMU3Slave(instanceName=name, **files), name)
        self._log = fmi3LogMessageCallback(lambda environment, status, category, message: self.listen(status, message))
        self._update = self._mover(moving)
        asked = (c_uint * len(moving))(*moving)
        self.fmu.component = self.fmu.fmi3InstantiateCoSimulation(
            name.encode(), self.fmu.guid.encode(), f"{self.fmu.unzipDirectory}/resources/".encode(), False, True, False,
            False, asked, len(moving), address(self.path) if self.path else None, self._log, self._update)  # fmt: skip
        if not self.fmu.component:
            raise SimulationError(f"{name}: fmi3InstantiateCoSimulation failed{': ' + self.said if self.said else ''}")
        if self.path:
            self.path.instance = pointer("void", self.fmu.component)
        array, count, state = c_void_p, c_size_t, c_void_p
        set_values = self.function("fmi3SetFloat64", array, count, array, count)
        get_values = self.function("fmi3GetFloat64", array, count, array, count)
        directional = self.function(
            "fmi3GetDirectionalDerivative", array, count, array, count, array, count, array, count
        )
        self.set = lambda references, n, values: set_values(references, n, values, n)
        self.get = lambda references, n, values: get_values(references, n, values, n)
        self.directional = lambda unknowns, n, knowns, m, seed, result: directional(
            unknowns, n, knowns, m, seed, m, result, n
        )
        self._step = self.function("fmi3DoStep", c_double, c_double, c_bool, c_void_p, c_void_p, c_void_p, c_void_p)
        self._answers = event, terminate, early, last = c_bool(), c_bool(), c_bool(), c_double()
        self._addresses = [byref(answer) for answer in (event, terminate, early, last)]
        self.step = self._one_step
        self._save = self.function("fmi3GetFMUState", state)
        self.restore = self.function("fmi3SetFMUState", state)
        self._free = self.function("fmi3FreeFMUState", state)
        self.reset = self.function("fmi3Reset")

    def _enter_initialisation(self, time: float) -> None:
        self.fmu.enterInitializationMode(startTime=time)

    def _one_step(self, time: float, step: float) -> None:
        self._step(time, step, False, *self._addresses)
        _, terminate, early, last = self._answers
        if terminate.value:
            raise EndRequestedError(self.name, last.value)
        if early.value:
            raise SimulationError(f"{self.name} stopped at {last.value:g} s, within the step from {time:g} s")

    def _mover(self, moving: Sequence[int]) -> fmi3IntermediateUpdateCallback:
        """The function that the FMU calls within a step: move_inputs of subsystem.c, or, without a compiler,
        the same in Python."""
        if not moving:
            return fmi3IntermediateUpdateCallback()
        self._moving = np.array(moving, np.uint32), np.zeros((5, len(moving)))
        references, coefficients = self._moving
        self.path = structures().new("Path *", {
            "set": structures().cast("Function", cast(self.fmu.dll.fmi3SetFloat64, c_void_p).value), "n": len(moving),
            "references": array("unsigned", references), "coefficients": array("double", coefficients),
        })  # fmt: skip
        try:
            return fmi3IntermediateUpdateCallback(address(library().move_inputs))
        except MissingToolError:
            return fmi3IntermediateUpdateCallback(self._move_inputs)

    def move(self, coefficients: np.ndarray, time: float, step: float) -> None:
        self._moving[1][:4] = coefficients
        self.path.begin, self.path.step = time, step

    def _move_inputs(self, environment: Any, time: float, set_requested: bool, *_: Any) -> None:
        path = self.path
        if set_requested and path.step:
            references, c = self._moving
            s = (time - path.begin) / path.step
            c[4] = c[0] + s * (c[1] + s * (c[2] + s * c[3]))
            self.set(references.ctypes.data, len(references), c[4].ctypes.data)
