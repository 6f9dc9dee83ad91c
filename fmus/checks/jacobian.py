"""The Jacobian of an instance by differences, and what the description says about it.

Model exchange: derivatives and continuous outputs by states and continuous inputs, in continuous-time mode.
Co-simulation: outputs by inputs in initialisation mode, because FMI 2 forbids to read an output after an input was set
between steps (FMI 2.0.4, 4.2.4).
"""

import time
from dataclasses import dataclass

import numpy as np

from fmus.checks.calls import CallFailedError
from fmus.checks.model import Unknown, Variable
from fmus.checks.simulation import values
from fmus.checks.trial import Trial

CHANGE = 1e-4  # of a known, against its value or its nominal
MOST = 200  # elements of knowns


@dataclass
class Column:
    """Differences of all unknowns by one element of a known. uncertainty bounds their error; kink says that the two
    sides differ, so that there is no derivative."""

    known: Variable
    element: int
    difference: np.ndarray
    uncertainty: np.ndarray


class Jacobian:
    """Knowns and unknowns of an instance at a point away from zero, where kinks are common."""

    def __init__(self, trial: Trial):
        model, self.trial = trial.model, trial
        self.fmu = trial.instance()
        self.fmu.enter_initialisation()
        self.entries = self._entries()
        inputs = [
            v
            for v in model.variables
            if v.causality == "input"
            and v.type in ("Real", "Float64")
            and not v.clocks
            and v.variability == "continuous"
        ]
        if trial.kind == "ModelExchange":
            self.fmu.exit_initialisation()
        self.states = (
            [s for s in model.states if s.type in ("Real", "Float64")] if trial.kind == "ModelExchange" else []
        )
        self.knowns = inputs + self.states
        self.unknowns = [u.variable for u in self.entries if u.variable is not None]
        self.names = [v.name for v in self.unknowns for _ in range(model.size(v))]
        self.owners = [u for u in self.entries if u.variable is not None for _ in range(model.size(u.variable))]
        self._move()

    def _entries(self) -> list[Unknown]:
        model = self.trial.model
        if self.trial.kind == "ModelExchange":
            found = [
                u for u in model.outputs if u.variable is not None and u.variable.variability == "continuous"
            ] + model.derivatives
        else:
            found = [u for u in model.initial_unknowns if u.variable is not None and u.variable.causality == "output"]
        return [
            u
            for u in found
            if u.variable is not None and u.variable.type in ("Real", "Float64") and not u.variable.clocks
        ]

    def _move(self) -> None:
        """All knowns a little off their start values, where the FMU accepts that; else back at the start values."""
        start = {id(v): self.get(v) for v in self.knowns}
        try:
            for i, known in enumerate(self.knowns):
                shifted = start[id(known)] + (0.1 + 0.03 * (i % 7)) * known.nominal
                self.put(known, np.clip(shifted, known.low, known.high))
            self.read()
        except CallFailedError:
            if self.fmu.phase in ("error", "fatal"):
                self.fmu.abandon()
                self.fmu = self.trial.instance()
                self.fmu.enter_initialisation()
                if self.trial.kind == "ModelExchange":
                    self.fmu.exit_initialisation()
            else:
                for known in self.knowns:
                    self.put(known, start[id(known)])

    def get(self, known: Variable) -> np.ndarray:
        return self._part(known) if known in self.states else self._input(known)

    def _input(self, known: Variable) -> np.ndarray:
        """An input's value; FMI 2 does not read inputs in initialisation mode."""
        if self.fmu.version == "2" and self.fmu.phase == "initialisation":
            return np.array([float(known.start or 0.0)])
        return self.fmu.get([known]).astype(float)

    def _part(self, state: Variable) -> np.ndarray:
        return self.fmu.states()[self._slice(state)]

    def _slice(self, state: Variable) -> slice:
        place = 0
        for other in self.trial.model.states:
            size = self.trial.model.size(other)
            if other is state:
                return slice(place, place + size)
            place += size
        raise KeyError(state.name)

    def put(self, known: Variable, value: np.ndarray) -> None:
        if known in self.states:
            states = self.fmu.states()
            states[self._slice(known)] = value
            self.fmu.set_states(states)
        else:
            self.fmu.set([known], value)

    def read(self) -> np.ndarray:
        return values(self.fmu, self.unknowns)

    def columns(self) -> list[Column]:
        """Differences by each element of each known, within the trial's time."""
        found: list[Column] = []
        began = time.monotonic()
        for known in self.knowns:
            for element in range(self.trial.model.size(known)):
                if len(found) >= MOST or time.monotonic() - began > self.trial.seconds:
                    return found
                column = self._column(known, element)
                if column is not None:
                    found.append(column)
        return found

    def _column(self, known: Variable, element: int) -> Column | None:
        """Central differences with two changes: their deviation bounds the curvature, that of the two sides a kink."""
        at = self.get(known)
        scale = CHANGE * max(
            abs(at[element]), abs(known.nominal) if np.isfinite(known.nominal) and known.nominal else 1.0
        )
        ends: dict[float, np.ndarray] = {}
        try:
            for factor in (1.0, 0.5, 0.0, -0.5, -1.0):
                shifted = at.copy()
                shifted[element] += factor * scale
                if not known.low <= shifted[element] <= known.high:
                    self.put(known, at)
                    return None
                self.put(known, shifted)
                ends[factor] = self.read()
            self.put(known, at)
        except CallFailedError:
            return None
        whole, half = (ends[1.0] - ends[-1.0]) / (2 * scale), (ends[0.5] - ends[-0.5]) / scale
        sides = (ends[0.5] + ends[-0.5] - 2 * ends[0.0]) / (0.5 * scale)
        rounding = 1e-13 * np.maximum(np.abs(ends[1.0]), np.abs(ends[-1.0])) / scale
        # A smooth function leaves curvature in `sides` that halves with the change; a kink leaves a jump that does not.
        wide = (ends[1.0] + ends[-1.0] - 2 * ends[0.0]) / scale
        kink = np.where(np.abs(sides) > 0.7 * np.abs(wide), np.abs(sides), 0.0)
        return Column(
            known, element, half, 10 * np.abs(whole - half) + kink + 1e-4 * np.abs(half) + 10 * rounding + 1e-9
        )
