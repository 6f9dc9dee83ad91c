"""A short simulation of one instance, which gives the same numbers each time.

Co-simulation: communication steps. Model exchange: Heun's method with the embedded Euler method as error estimate
(Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.4), events at the end of a step.
"""

import hashlib
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fmus.checks.calls import CallFailedError, EndedError
from fmus.checks.instance import Instance
from fmus.checks.model import FLOATS, INTEGERS, Model, Variable

POINTS = 300  # communication points of a run
EVALUATIONS = 5000  # of the model equations, in model exchange
TOLERANCE = 1e-3
DATA = ("String", "Binary")
LARGEST_KEPT = 64  # bytes of a string or of binary data, in a run
RECORDED = 200  # variables, where there are no outputs
Drive = Callable[[Instance], None]  # sets the inputs of an instance for its time


@dataclass
class Run:
    """Values (points, columns) at the times; the columns are elements of variables. data are the values of strings and
    binary variables at each time, digests of long ones. ended: the FMU has asked for the end."""

    names: list[str]  # of the columns
    data_names: list[str] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    rows: list[np.ndarray] = field(default_factory=list)
    data: list[list[bytes]] = field(default_factory=list)
    ended: bool = False

    @property
    def values(self) -> np.ndarray:
        return np.array(self.rows).reshape(len(self.rows), -1)


def recorded(model: Model) -> list[Variable]:
    """Numeric outputs; without any, the first numeric local variables."""
    numeric = [v for v in model.variables if v.type in (*FLOATS, *INTEGERS, "Boolean", "Enumeration") and not v.clocks]
    outputs = [v for v in numeric if v.causality == "output"]
    return outputs or [v for v in numeric if v.causality == "local"][:RECORDED]


def recorded_data(model: Model) -> list[Variable]:
    """Outputs that are strings or binary data, in the order of their types."""
    found = [v for v in model.variables if v.type in DATA and v.causality == "output" and not v.clocks]
    return sorted((v for v in found if model.size(v)), key=lambda v: DATA.index(v.type))


def read_data(instance: Instance, variables: list[Variable]) -> list[bytes]:
    """All elements of strings and binary variables in their order, which is that of their types."""
    texts, binaries = ([v for v in variables if v.type == kind] for kind in DATA)
    return (instance.texts(texts) if texts else []) + (instance.binaries(binaries) if binaries else [])


def read_all(instance: Instance, variables: list[Variable]) -> None:
    """Read variables of any type. Raises CallFailedError."""
    values(instance, [v for v in variables if v.type not in DATA])
    read_data(instance, [v for v in variables if v.type in DATA])


def step_size(model: Model, kind: str) -> float:
    """The communication step [s]: of the default experiment, and a multiple of a fixed internal step."""
    step, start, stop = (model.experiment(name) for name in ("stepSize", "startTime", "stopTime"))
    start = start if math.isfinite(start) else 0.0
    element = model.root.find(kind)
    fixed = float((element.get("fixedInternalStepSize") if element is not None else None) or "nan")
    if not (math.isfinite(step) and step > 0):
        step = (stop - start) / POINTS if math.isfinite(stop) and stop > start else 1e-3
    if math.isfinite(fixed) and fixed > 0:
        return max(1, round(step / fixed)) * fixed
    return step


def steps(model: Model, kind: str, most: int = POINTS) -> int:
    """Communication steps of a run, which does not pass the stop time of the default experiment."""
    stop, start = model.experiment("stopTime"), model.experiment("startTime")
    start = start if math.isfinite(start) else 0.0
    room = (stop - start) / step_size(model, kind) if math.isfinite(stop) and stop > start else math.inf
    return max(1, min(most, math.floor(room + 1e-9) if math.isfinite(room) else most))


def values(instance: Instance, variables: list[Variable]) -> np.ndarray:
    """All elements of numeric variables (n,), of whatever types."""
    by_type: dict[str, list[Variable]] = {}
    for variable in variables:
        by_type.setdefault(variable.type, []).append(variable)
    found = {}
    for group in by_type.values():
        flat, place = instance.get(group), 0
        for variable in group:
            size = instance.model.size(variable)
            found[id(variable)] = flat[place : place + size].astype(float)
            place += size
    return np.concatenate([found[id(v)] for v in variables]) if variables else np.zeros(0)


class Simulation:
    """A run of an initialised instance, one communication step after another. drive(instance) sets its inputs for the
    time that it has reached: before each communication step, in model exchange before each evaluation."""

    def __init__(self, instance: Instance, drive: Drive | None = None):
        self.instance, self.drive = instance, drive
        self._variables, self._data = recorded(instance.model), recorded_data(instance.model)
        size = instance.model.size
        names, data_names = ([v.name for v in some for _ in range(size(v))] for some in (self._variables, self._data))
        self.run = Run(names, data_names)
        self.integrator = Integrator(instance, drive) if instance.exchange else None
        self.record()

    def put(self) -> None:
        """Set the inputs for the next communication step."""
        if self.drive is not None:
            self.drive(self.instance)

    def advance(self, step: float) -> bool:
        """To the next communication point [s]; False when the evaluations are used up. Raises EndedError."""
        if self.integrator is not None:
            return self.integrator.advance(self.instance.time + step)
        self.instance.do_step(step)
        return True

    def record(self) -> None:
        """Keep the values at the present time."""
        self.run.times.append(self.instance.time)
        self.run.rows.append(values(self.instance, self._variables))
        self.run.data.append([_kept(one) for one in read_data(self.instance, self._data)])


def simulate(instance: Instance, count: int, step: float, seconds: float = math.inf, drive: Drive | None = None) -> Run:
    """Run an initialised instance over at most `count` communication steps and about `seconds` of wall-clock time."""
    began, simulation = time.monotonic(), Simulation(instance, drive)
    try:
        for _ in range(count):
            simulation.put()
            if not simulation.advance(step):
                break
            simulation.record()
            if time.monotonic() - began > seconds:
                break
    except EndedError:
        simulation.run.ended = True
    return simulation.run


def _kept(data: bytes) -> bytes:
    """Data that is short enough to be kept, else its digest."""
    return data if len(data) <= LARGEST_KEPT else hashlib.sha256(data).hexdigest().encode()


class Integrator:
    """Integrates one model-exchange instance in continuous-time mode."""

    def __init__(self, instance: Instance, drive: Drive | None = None):
        self.instance, self.left, self.step, self.drive = instance, EVALUATIONS, math.inf, drive
        self.indicators = instance.indicators()

    def advance(self, until: float) -> bool:
        """To the time [s], through events; False when the evaluations are used up."""
        fmu = self.instance
        while fmu.time < until - 1e-12 * max(1.0, abs(until)):
            if self.left <= 0:
                return False
            end = min(until, max(fmu.next_event, fmu.time))
            if end > fmu.time:
                self._step(end)
            asked = fmu.completed_step()
            indicators = fmu.indicators()
            crossed = bool(np.any((indicators > 0) != (self.indicators > 0)))
            if asked or crossed or fmu.time >= fmu.next_event:
                fmu.event()
                indicators = fmu.indicators()
            self.indicators = indicators
        return True

    def _step(self, end: float) -> None:
        """One accepted step, at most to the end [s]."""
        fmu, begin, states = self.instance, self.instance.time, self.instance.states()
        rates, scale = fmu.rates(), TOLERANCE * np.maximum(np.abs(states), _nominals(fmu))
        self.left -= 1
        step = min(self.step, end - begin)
        smallest = 1e-12 * max(1.0, abs(begin))
        while True:
            error, after = self._attempt(
                end if step >= end - begin else begin + step, states, rates, step, scale, step <= smallest
            )
            factor = 0.2 if not math.isfinite(error) else min(5.0, max(0.2, 0.9 / math.sqrt(max(error, 1e-12))))
            if error <= 1 or step <= smallest:
                break
            step = max(step * factor, smallest)
            self._at(begin)
            fmu.set_states(states)
        fmu.set_states(states + step / 2 * (rates + after))
        self.step = max(step * factor, smallest)

    def _attempt(
        self, time: float, states: np.ndarray, rates: np.ndarray, step: float, scale: np.ndarray, last: bool
    ) -> tuple[float, np.ndarray]:
        """The error of an Euler step in units of the tolerance, and the derivatives at its end."""
        self.left -= 1
        try:
            self._at(time)
            self.instance.set_states(states + step * rates)
            after = self.instance.rates()
        except CallFailedError as failed:  # a discarded state: a shorter step may do
            if last or not failed.call.status.endswith("Discard"):
                raise
            return math.inf, rates
        error = float(np.max(step / 2 * np.abs(after - rates) / scale, initial=0.0))
        return (error if math.isfinite(error) else math.inf), after

    def _at(self, time: float) -> None:
        """Set the time [s], and the inputs for it."""
        self.instance.set_time(time)
        if self.drive is not None:
            self.drive(self.instance)


def _nominals(fmu: Instance) -> np.ndarray:
    sizes = [(abs(v.nominal) or 1.0, fmu.model.size(v)) for v in fmu.model.states]
    return np.concatenate([np.full(size, value) for value, size in sizes]) if sizes else np.zeros(0)


SAME = 1e-9  # of a value, against its largest: the order of summation may differ, nothing else


def difference(first: Run, second: Run, same: float = SAME) -> str:
    """The first variable that differs between two runs by more than `same`, with its values; empty where none does."""
    count = min(len(first.rows), len(second.rows))
    a, b = first.values[:count], second.values[:count]
    scale = np.max(np.abs(np.where(np.isfinite(a), a, 0)), axis=0, initial=0.0)
    unequal = ~((np.abs(a - b) <= same * scale) | (np.isnan(a) & np.isnan(b)) | (a == b))
    if not unequal.any():
        return _data_difference(first, second)
    row, column = np.argwhere(unequal)[0]
    return f"{first.names[column]} is {b[row, column]:.9g} at {first.times[row]:g} s, not {a[row, column]:.9g}"


def _data_difference(first: Run, second: Run) -> str:
    for when, a, b in zip(first.times, first.data, second.data, strict=False):
        for name, one, other in zip(first.data_names, a, b, strict=True):
            if one != other:
                return f"{name} is {other!r} at {when:g} s, not {one!r}"
    return ""
