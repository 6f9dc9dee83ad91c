"""Inputs that vary and parameters off their start values, for trials that compare runs.

A state that only an input changes stays at its start value while the inputs do, so that a run with constant inputs does
not show whether the FMU resets, saves or shares it. An input k with the start value s varies with the time t since the
start as

    u = s + a (0.7 sin(w t) + 0.3 sin(sqrt(2) w t)),    w = 2 pi / (25 h (1 + frac(k phi))),

h the communication step, phi the golden ratio: zero at the start, the same in every run, no two inputs in proportion.
a is a tenth of the nominal value or of the start value, the larger of both, and at most a quarter of the declared range,
which u does not leave.
"""

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from fmus.checks.calls import CallFailedError, FmiCall
from fmus.checks.instance import Instance
from fmus.checks.model import FLOATS, INTEGERS, Model, Variable
from fmus.checks.problem import Problem
from fmus.checks.settings import start_values
from fmus.checks.simulation import Run, step_size, values
from fmus.checks.trial import Trial

SHARE = 0.1  # of the nominal or start value: the amplitude of an input
CHANGE = 0.01  # of the start or nominal value of a parameter
PERIOD = 25  # communication steps
SECONDS = 0.5  # of wall-clock time for each run: a trial makes up to eleven of them
GOLDEN = (1 + math.sqrt(5)) / 2
COMPARED = "so that resets, restored states and instances were compared with {} only"
REFUSED = "inputs that vary are not accepted ({}), " + COMPARED.format("constant inputs")
KEPT = "parameters off their start values are not accepted ({}), " + COMPARED.format("start values")


class NotAcceptedError(Exception):
    """The FMU refuses values that differ from the start values; the text says how."""


@dataclass(frozen=True)
class Given:
    """Values (n,) of variables of one type, array elements one after another."""

    variables: list[Variable]
    values: np.ndarray


class Excitation:
    """Sets the inputs of an instance for its time. The second of two instances gets other values at the same times."""

    def __init__(self, trial: Trial, second: bool = False):
        inputs = _varied_inputs(trial)
        groups = [[v for v in inputs if v.type == kind] for kind in FLOATS]
        self._by_type = [group for group in groups if group]
        ordered = [v for group in self._by_type for v in group]
        starts = [_starts(trial.model, v) for v in ordered]
        self._start = _joined(starts)
        self._amplitude = _joined([_amplitude(v, s) for v, s in zip(ordered, starts, strict=True)])
        self._low, self._high = (
            _joined([np.full(len(s), bound) for s, bound in zip(starts, bounds, strict=True)])
            for bounds in ([v.low for v in ordered], [v.high for v in ordered])
        )
        places = np.arange(len(self._start)) + (0.5 if second else 0.0)
        self._frequency = 2 * np.pi / (PERIOD * step_size(trial.model, trial.kind) * (1 + places * GOLDEN % 1))
        self._sign = -1.0 if second else 1.0
        self._counts = [sum(map(trial.model.size, group)) for group in self._by_type]

    def __bool__(self) -> bool:
        return bool(self._by_type)

    def constant(self) -> "Excitation":
        """The same inputs, set to their start values at the same times."""
        found = copy(self)
        found._sign = 0.0
        return found

    def __call__(self, fmu: Instance) -> None:
        """Set the inputs. Raises CallFailedError."""
        angle = self._frequency * (fmu.time - fmu.start)
        shape = self._sign * (0.7 * np.sin(angle) + 0.3 * np.sin(math.sqrt(2) * angle))
        wanted, place = np.clip(self._start + self._amplitude * shape, self._low, self._high), 0
        for group, count in zip(self._by_type, self._counts, strict=True):
            fmu.set(group, wanted[place : place + count])
            place += count


def _joined(parts: Sequence[np.ndarray]) -> np.ndarray:
    return np.concatenate(parts) if parts else np.zeros(0)


def _amplitude(variable: Variable, start: np.ndarray) -> np.ndarray:
    size = SHARE * np.maximum(_nominal(variable), np.abs(start))
    room = variable.high - variable.low
    return np.minimum(size, room / 4) if math.isfinite(room) else size


def _nominal(variable: Variable) -> float:
    return abs(variable.nominal) or 1.0 if math.isfinite(variable.nominal) else 1.0


def _starts(model: Model, variable: Variable) -> np.ndarray:
    """Finite start values within the bounds; empty where there are none."""
    found = start_values(variable, model.size(variable))
    if found is None or not np.isfinite(found).all() or (found < variable.low).any() or (found > variable.high).any():
        return np.zeros(0)
    return found


def _usable(trial: Trial, variable: Variable) -> bool:
    readable = variable.real and not variable.clocks and variable.reference is not None
    return readable and variable.low <= variable.high and len(_starts(trial.model, variable)) > 0


def _varied_inputs(trial: Trial) -> list[Variable]:
    """The real inputs that can be set between steps: discrete ones need event mode where the instance has it."""
    events = trial.kind == "ModelExchange" or trial.flag("", "hasEventMode")
    permitted = ("continuous",) if events else ("continuous", "discrete")
    inputs = [v for v in trial.model.variables if v.causality == "input" and v.variability in permitted]
    return [v for v in inputs if _usable(trial, v)]


def changed_parameters(trial: Trial) -> list[Given]:
    """Real parameters a little off their start values, within their bounds; by type."""
    return _parameters(trial, 1.0)


def start_parameters(trial: Trial) -> list[Given]:
    """The same parameters at their start values."""
    return _parameters(trial, 0.0)


def _parameters(trial: Trial, share: float) -> list[Given]:
    found = [v for v in trial.model.variables if v.causality == "parameter" and _usable(trial, v)]
    groups = [[v for v in found if v.type == kind] for kind in FLOATS]
    return [Given(group, np.concatenate([_changed(trial, v, share) for v in group])) for group in groups if group]


def _changed(trial: Trial, variable: Variable, share: float) -> np.ndarray:
    start = _starts(trial.model, variable)
    change = share * CHANGE * np.where(start == 0, _nominal(variable), np.abs(start))
    up, down = start + change, start - change
    return np.where(up <= variable.high, up, np.where(down >= variable.low, down, start))


def put(fmu: Instance, given: Sequence[Given]) -> None:
    """Set parameters. Raises CallFailedError."""
    for one in given:
        fmu.set(one.variables, one.values)


# Runs ------------------------------------------------------------------------------------------------------


@dataclass
class Settings:
    """Values (n,) of numeric inputs and parameters of an instance, with the name of each element."""

    names: list[str]
    values: np.ndarray

    def difference(self, other: "Settings") -> str:
        """The first value of the other one that differs, as in `k is 3, not 2`; empty where none does."""
        unequal = ~(
            np.isclose(other.values, self.values, rtol=1e-9, atol=0) | (np.isnan(other.values) & np.isnan(self.values))
        )
        if not unequal.any():
            return ""
        k = int(np.argmax(unequal))
        return f"{self.names[k]} is {other.values[k]:.9g}, not {self.values[k]:.9g}"


def settings(fmu: Instance, *causalities: str) -> Settings:
    """The numeric variables of these causalities of an initialised instance. Raises CallFailedError."""
    kinds, size = (*FLOATS, *INTEGERS, "Boolean", "Enumeration"), fmu.model.size
    found = [v for v in fmu.model.variables if v.causality in causalities and v.type in kinds]
    found = [v for v in found if not v.clocks and v.reference is not None and size(v)]
    return Settings([v.name for v in found for _ in range(size(v))], values(fmu, found))


@dataclass
class First:
    """A run of a new instance, which is still open, its inputs and parameters after initialisation, and what has driven
    it."""

    fmu: Instance
    drive: Excitation | None
    inputs: Settings
    parameters: Settings
    run: Run


def accepted_run(trial: Trial, count: int) -> tuple[First, list[Problem]]:
    """A run with inputs that vary; where the FMU does not accept them with constant ones, and a note of it."""
    try:
        return first_run(trial, count, Excitation(trial) or None), []
    except NotAcceptedError as reason:
        return first_run(trial, count, None), [trial.note(REFUSED.format(reason))]


def first_run(trial: Trial, count: int, drive: Excitation | None, parameters: Sequence[Given] = ()) -> First:
    """A run with inputs that vary, or with changed parameters, or both.

    Raises NotAcceptedError where the FMU refuses them, warns of them or gives numbers that are not finite, and
    CallFailedError where it fails with start values, too.
    """

    def warned() -> FmiCall | None:
        """The warning of a run in which the same variables are set to their start values."""
        still = _attempted(
            trial, count, drive.constant() if drive else None, start_parameters(trial) if parameters else ()
        ).fmu
        still.close()
        return still.warned

    try:
        found = _attempted(trial, count, drive, parameters)
    except CallFailedError as failed:
        trial.instances[-1].close()
        warned()
        raise NotAcceptedError(failed.message) from failed
    said, bad = found.fmu.warned, np.argwhere(~np.isfinite(found.run.values))
    if len(bad):
        row, column = bad[0]
        value, when = found.run.values[row, column], found.run.times[row]
        found.fmu.close()
        raise NotAcceptedError(f"{found.run.names[column]} is {value:g} at {when:g} s")
    if said is None:
        return found
    found.fmu.close()
    if warned() is None:
        raise NotAcceptedError(f"{said.name} returns {said.status}")
    return _attempted(trial, count, drive, parameters)


def _attempted(trial: Trial, count: int, drive: Excitation | None, parameters: Sequence[Given]) -> First:
    fmu = trial.instance()
    put(fmu, parameters)
    fmu.initialise()
    return First(fmu, drive, settings(fmu, "input"), settings(fmu, "parameter"), trial.simulate(fmu, count, drive))
