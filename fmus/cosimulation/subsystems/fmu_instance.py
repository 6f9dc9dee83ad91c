"""One instance of a co-simulation FMU, FMI 2.0 or 3.0, that a coupling can step.

All buffers are allocated once; a step converts nothing. The capabilities (polynomial inputs, output derivatives, saved
states, directional derivatives) are those of the model description. The accepted order of input polynomials, which a
model description does not state, is determined with a separate instance.
"""

from collections.abc import Callable, Mapping, Sequence
from ctypes import c_void_p
from pathlib import Path
from typing import Self

import numpy as np
from fmpy.model_description import ModelVariable

from fmus.cosimulation.polynomials import ORDER, derivatives
from fmus.cosimulation.subsystems.archive import open_archive
from fmus.cosimulation.subsystems.fmi_calls import Calls, Calls2, Calls3
from fmus.cosimulation.subsystems.stated_units import described_unit, stated_units
from fmus.cosimulation.subsystems.typed_values import REAL, Value, typed
from fmus.support.errors import InputError, SimulationError, unknown
from fmus.support.foreign_code import entered

SHOWN = 6  # so many names of inputs, and of outputs, are in the repr
CALLS: dict[str, Callable[[str, Mapping[str, str], Sequence[int]], Calls]] = {"2": Calls2, "3": Calls3}


class Signals:
    """Some variables of an FMU with a buffer for their values."""

    def __init__(self, variables: list[ModelVariable]):
        self.variables = variables
        self.names = tuple(v.name for v in variables)
        self.references = np.array([v.valueReference for v in variables], np.uint32)
        self.values = np.zeros(len(variables))
        self.call = (self.references.ctypes.data, len(variables), self.values.ctypes.data)


class FmuInstance:
    """One instance of an FMU, initialised at its start values with some of them replaced; a context
    manager that frees it. `units` states the unit of variables whose unit the description leaves out.

        with FmuSubsystem("rider_mean_2011.fmu", values={"steer_angle": 0.01}) as rider:
            torques = rider.exchange(rider.present_inputs)

    Raises InputError for a file that is no FMU, a platform without a binary, or a value that is refused.
    """

    def __init__(self, path: str | Path, name: str = "", values: Mapping[str, Value] | None = None, time: float = 0.0,
                 units: Mapping[str, str] | None = None):  # fmt: skip
        self.path = Path(path)
        self._archive = open_archive(path)
        self.description = self._archive.description
        self.name = name or self.description.modelName
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.units = stated_units(self.name, self.variables, units or {})
        real = [v for v in self.description.modelVariables if v.type in REAL and not v.dimensions]
        self._inputs = Signals([v for v in real if v.causality == "input"])
        self._outputs = Signals([v for v in real if v.causality == "output"])
        self.inputs, self.outputs = self._inputs.names, self._outputs.names
        rates = [u.variable for u in self.description.derivatives]
        self._rates = Signals(rates)
        self._states = Signals([v.derivative for v in rates])
        self.unknowns = np.concatenate([self._rates.references, self._outputs.references])
        self.knowns = np.concatenate([self._states.references, self._inputs.references])
        can = self.description.coSimulation
        self.can_restore: bool = can.canGetAndSetFMUstate
        self.output_order: int = can.maxOutputDerivativeOrder
        self.has_directional_derivatives = self._archive.has_directional_derivatives
        self._moving = (
            self._inputs.references.tolist()
            if can.providesIntermediateUpdate and set(self.inputs) <= self._archive.moving
            else []
        )
        self.input_order = ORDER if self._moving else self._accepted_order() if can.canInterpolateInputs else 0
        self.calls = self._instance()
        self._saved: list[c_void_p] = []
        self._slopes = np.zeros((ORDER, len(self.inputs)))
        self._slope_references = np.tile(self._inputs.references, ORDER)
        self._slope_orders = np.repeat(np.arange(1, ORDER + 1, dtype=np.int32), len(self.inputs))
        self._all_output_orders = np.repeat(np.arange(1, ORDER + 1, dtype=np.int32), len(self.outputs))
        self._output_slopes = np.zeros(len(self.outputs))
        self.start(values or {}, time)
        self.feedthrough = self._feedthrough()
        if self.calls.set_slopes is None and self.inputs and not self.has_directional_derivatives:
            self.output_order = 0  # the effect of moving inputs on an output is not available

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __repr__(self) -> str:
        sides = (f"{len(names)} {what}" if len(names) > SHOWN else f"{what} {', '.join(names) or 'none'}"
                 for what, names in (("inputs", self.inputs), ("outputs", self.outputs)))  # fmt: skip
        return f"<{type(self).__name__} {self.name}, FMI {self.description.fmiVersion}, {', '.join(sides)}>"

    @property
    def states(self) -> tuple[str, ...]:
        return self._states.names

    # Lifetime ------------------------------------------------------------------------------------------------------

    def _instance(self) -> Calls:
        entered(str(self.path))
        try:
            return CALLS[self._archive.version](self.name, self._archive.library, self._moving)
        except Exception as error:  # fmpy raises plain exceptions for a missing platform or a failed instance
            raise InputError(f"{self.path} cannot be loaded on this machine: {error}") from None

    def _accepted_order(self) -> int:
        """The highest order of input derivative that the FMU takes, determined with an instance that is then freed."""
        for order in range(ORDER, 0, -1):
            trial = self._instance()
            try:
                trial.start(0.0)
                orders = np.full(len(self.inputs), order, np.int32)
                if trial.set_slopes is None or not self.inputs:
                    return 0
                trial.set_slopes(*self._inputs.call[:2], orders.ctypes.data, self._inputs.values.ctypes.data)
                return order
            except SimulationError:
                continue
            finally:
                trial.close()
        return 0

    def start(self, values: Mapping[str, Value], time: float = 0.0) -> None:
        """Initialise with parameters, inputs and starts of states by name. Raises InputError where one is refused."""
        for name in values:
            if name not in self.variables:
                raise unknown(
                    f"variable of {self.name}",
                    name,
                    (n for n, v in self.variables.items() if v.causality in ("parameter", "input") or n in self.states),
                )
        self.values, self.time, self.begin = dict(values), time, time
        for name, value in values.items():
            try:
                self._set_one(name, value)
            except SimulationError as error:
                raise InputError(str(error)) from None
        self.calls.start(time)
        for k, name in enumerate(self.inputs):
            self._inputs.values[k] = float(values.get(name, self.variables[name].start or 0.0))
        self.calls.get(*self._outputs.call)

    def restart(self, values: Mapping[str, Value], time: float = 0.0) -> None:
        """Reset, and initialise with other values."""
        self.calls.reset()
        self.start(values, time)

    def _set_one(self, name: str, value: Value) -> None:
        variable = self.variables[name]
        if variable.type not in REAL:
            self.calls.set_typed(variable, value)
            return
        signal = Signals([variable])
        signal.values[0] = typed(variable, value)
        self.calls.set(*signal.call)

    def close(self) -> None:
        """Free the instance; calling it again does nothing."""
        while self._saved and self.calls.alive:
            self.calls.free(self._saved.pop())
        self.calls.close()

    # Values ----------------------------------------------------------------------------------------------------

    def get(self, name: str) -> float:
        """The present value of a variable. Raises InputError when there is none of that name."""
        if name not in self.variables:
            raise unknown(f"variable of {self.name}", name, self.variables)
        signal = Signals([self.variables[name]])
        self.calls.get(*signal.call)
        return float(signal.values[0])

    def set(self, name: str, value: float) -> None:
        """Set an input or a tunable parameter between steps."""
        if name in self.inputs:
            self._inputs.values[self.inputs.index(name)] = value
        self._set_one(name, value)

    def unit_of(self, variable: str) -> str:
        """The unit of a variable; an empty text where it is unknown."""
        return self.units.get(variable) or described_unit(self.variables[variable])

    @property
    def present_inputs(self) -> np.ndarray:
        """The inputs (nu,) as they were set last."""
        return self._inputs.values

    def exchange(self, inputs: np.ndarray) -> np.ndarray:
        self._inputs.values[:] = inputs
        self.calls.set(*self._inputs.call)
        return self.present_outputs()

    def present_outputs(self) -> np.ndarray:
        """The outputs (ny,) without setting an input before."""
        self.calls.get(*self._outputs.call)
        return self._outputs.values

    def output_slope(self, slopes: np.ndarray) -> np.ndarray:
        order = len(slopes)
        if self.calls.set_slopes is None:
            return self._slope_along(slopes)
        if self.input_order:
            given = min(order, self.input_order)
            self._slopes[:given] = slopes[:given]
            self._set_slopes(given)
        orders = self._all_output_orders[(order - 1) * len(self.outputs) :]
        self.calls.get_slopes(*self._outputs.call[:2], orders.ctypes.data, self._output_slopes.ctypes.data)
        return self._output_slopes

    def _slope_along(self, slopes: np.ndarray) -> np.ndarray:
        """The same where the FMU takes no input derivatives: y^(k) = C x^(k) + D u^(k), x^(k+1) = A x^(k) + B u^(k)."""
        rates = self.state_rates()
        for given in slopes:
            found = self.along(np.concatenate([rates, given]))
            rates = found[: len(rates)]
        return found[len(rates) :]

    def along(self, seed: np.ndarray) -> np.ndarray:
        """The directional derivative of rates and outputs (nx + ny,) along a seed of states and inputs (nx + nu,)."""
        found = np.zeros(len(self.unknowns))
        self.calls.directional(
            self.unknowns.ctypes.data,
            len(self.unknowns),
            self.knowns.ctypes.data,
            len(self.knowns),
            seed.ctypes.data,
            found.ctypes.data,
        )
        return found

    def _set_slopes(self, order: int) -> None:
        assert self.calls.set_slopes is not None
        self.calls.set_slopes(
            self._slope_references.ctypes.data,
            order * len(self.inputs),
            self._slope_orders.ctypes.data,
            self._slopes.ctypes.data,
        )

    def state_values(self) -> np.ndarray:
        """The states (nx,) at present."""
        self.calls.get(*self._states.call)
        return self._states.values

    def state_rates(self) -> np.ndarray:
        self.calls.get(*self._rates.call)
        return self._rates.values

    # Steps -----------------------------------------------------------------------------------------------------

    def step(self, coefficients: np.ndarray, step: float) -> None:
        self._inputs.values[:] = coefficients[0]
        self.calls.set(*self._inputs.call)
        if self._moving:
            self.calls.move(coefficients, self.time, step)
        elif self.input_order:
            self._slopes[:] = derivatives(coefficients, step)[1:]
            self._set_slopes(self.input_order)
        self.calls.step(self.time, step)
        self.time += step

    def save(self, into: tuple[c_void_p, float] | None = None) -> tuple[c_void_p, float]:
        saved = into[0] if into else c_void_p()
        if into is None:
            self._saved.append(saved)
        self.calls.save(saved)
        return saved, self.time

    def restore(self, saved: tuple[c_void_p, float]) -> None:
        self.calls.restore(saved[0])
        self.time = saved[1]

    def set_states(self, states: np.ndarray) -> None:
        """Set the states (nx,), where the FMU allows that at present. Raises SimulationError where not."""
        self._states.values[:] = states
        self.calls.set(*self._states.call)

    # Structure -------------------------------------------------------------------------------------------------

    def references(self) -> dict[str, tuple[str, np.ndarray]]:
        """The value references and orders that a compiled master needs: type in C and array by name in structures.h."""
        return {"unknowns": ("unsigned", self.unknowns), "knowns": ("unsigned", self.knowns),
                "slope_inputs": ("unsigned", self._slope_references), "slope_orders": ("int", self._slope_orders),
                "output_orders": ("int", self._all_output_orders)}  # fmt: skip

    def twin(self) -> "FmuInstance":
        """Another instance of the same FMU with the same parameters, at its start."""
        return type(self)(self.path, self.name, self.values, self.time, self.units)

    def _feedthrough(self) -> np.ndarray:
        """(ny, nu) from the description; where it states no dependencies, from the outputs that
        change with an input."""
        declared = {u.variable.name: u.dependencies for u in self.description.outputs}
        found = np.zeros((len(self.outputs), len(self.inputs)), bool)
        silent = [k for k, name in enumerate(self.outputs) if declared.get(name) is None]
        for k, name in enumerate(self.outputs):
            found[k] = [any(d.name == i for d in declared.get(name) or ()) for i in self.inputs]
        if silent:
            found[silent] = self._tried_feedthrough()[silent]
        return found

    def _tried_feedthrough(self) -> np.ndarray:
        inputs = self._inputs.values.copy()
        base = self.exchange(inputs).copy()
        depends = [self.exchange(inputs + column) != base for column in np.eye(len(inputs))]
        self.exchange(inputs)
        return np.array(depends).reshape(len(inputs), len(base)).T

