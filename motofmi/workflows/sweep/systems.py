"""The systems of a study: vehicles with devices at their ports, and the parameters that change from run to run."""

import hashlib
import tempfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.model_description import ModelVariable

from fmus.cosimulation.subsystems.archive import model_description
from fmus.cosimulation.subsystems.stated_units import described_unit
from fmus.cosimulation.subsystems.typed_values import REAL
from fmus.declaration.component import Component, in_bounds
from fmus.declaration.variables import Variable
from fmus.linear_analysis.linearisation import StateSpace, linearise
from fmus.support.files import write_atomically
from motofmi.workflows.components import by_part
from motofmi.workflows.parts import GivenFmu
from motofmi.workflows.ridden_fmus import over_speed_fmus, ridden_fmus
from vehicle_fmu import ridden
from vehicle_fmu.ridden import by_name, rigid_body
from vehicle_fmu.stacked_modes import StackedLinearised

RIDER = "rider"


@dataclass(frozen=True)
class Archive:
    """An FMU that travels with the study: a worker writes it once, under the hash of its contents.

    changed are values of its parameters, in the units that it states.
    """

    name: str
    contents: bytes
    changed: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, path: Path) -> "Archive":
        """The archive at a path."""
        return cls(path.stem, path.read_bytes())

    @cached_property
    def table(self) -> dict[str, Variable]:
        """The real parameters by name, with the unit, the start value and the bounds that the FMU states."""
        return {v.name: Variable("parameter", described_unit(v), v.description or "", start=float(v.start),
                                 min=_limit(v, "min", -inf), max=_limit(v, "max", inf), name=v.name)
                for v in model_description(self.path()).modelVariables
                if v.causality == "parameter" and v.type in REAL and v.start is not None}  # fmt: skip

    @property
    def values(self) -> dict[str, float]:
        """The values of the parameters by name."""
        return {name: self.changed.get(name, row.start) for name, row in self.table.items()}

    def with_values(self, **values: float) -> "Archive":
        """The archive with changed parameters. Raises InputError for a value outside its bounds."""
        for name, value in values.items():
            in_bounds(value, self.table[name], self.name)
        return replace(self, changed={**self.changed, **values})

    @property
    def sha256(self) -> str:
        """The hash of the contents."""
        return hashlib.sha256(self.contents).hexdigest()

    def path(self) -> Path:
        """Where the archive is on this machine."""
        path = Path(tempfile.gettempdir()) / "motofmi_fmus" / self.sha256 / f"{self.name}.fmu"
        if not path.exists():
            write_atomically(path, lambda beside: beside.write_bytes(self.contents), cache=True)
        return path


Part = Component | Archive


@dataclass(frozen=True)
class Varied:
    """A parameter of a part (`vehicle`, `rider`, `device`) with its values (n,) along a dimension of the grid."""

    dim: int
    part: str
    name: str
    values: np.ndarray


@dataclass(frozen=True)
class Systems:
    """Every vehicle with every set of devices; rider is the member of a population that rides in every run."""

    vehicles: Sequence[Part]
    devices: Sequence[Sequence[Part]]
    rider: Component | None
    varied: Sequence[Varied]

    def parts(self, vehicle: int, device: int) -> dict[str, Part]:
        """The parts of a system by the names under which a study sets their parameters."""
        rider = {} if self.rider is None else {RIDER: self.rider}
        whole = {"vehicle": self.vehicles[vehicle]} if self.vehicles else {}
        return {**whole, **rider, **by_name(self.devices[device])}

    def check(self) -> None:
        """Raises InputError for a vehicle and devices that do not go together, such as two riders at the handlebar."""
        for vehicle in range(len(self.vehicles)):
            for device in range(len(self.devices)):
                whole, *held = self.parts(vehicle, device).values()
                if isinstance(whole, Component):
                    ridden(whole, *(part for part in held if isinstance(part, Component)))

    def values(self, indices: np.ndarray) -> dict[tuple[str, str], np.ndarray]:
        """The values (n,) of the varied parameters by part and name, in runs at places (n, dims)."""
        return {(v.part, v.name): v.values[indices[:, v.dim]] for v in self.varied}

    def at(self, vehicle: int, device: int, values: Mapping[tuple[str, str], float]) -> list[Part]:
        """Vehicle, rider and devices with the values of one run. Raises InputError for a value outside its bounds."""
        parts = self.parts(vehicle, device)
        changed: dict[str, dict[str, float]] = {}
        for (part, name), value in values.items():
            changed.setdefault(part, {})[name] = float(value)
        return [part.with_values(**changed[n]) if n in changed else part for n, part in parts.items()]

    def stacked(self, vehicle: int, device: int, indices: np.ndarray) -> StackedLinearised:
        """The linearisation of runs of one vehicle and device at places (n, dims), for `stacked_modes`.

        Raises InputError for a value outside its bounds.
        """
        parts, values = self.parts(vehicle, device), self.values(indices)
        components = [part for part in parts.values() if isinstance(part, Component)]
        if len(components) == len(parts) and not any(rigid_body(part) for part in components[1:]):
            return self._by_arrays(parts, values)
        return self._one_by_one([self.at(vehicle, device, {key: column[k] for key, column in values.items()})
                                 for k in range(len(indices))])  # fmt: skip

    def _by_arrays(self, parts: Mapping[str, Any], values: Mapping[tuple[str, str], np.ndarray]) -> StackedLinearised:
        """One system, linearised at arrays of its parameters."""
        for (part, name), column in values.items():
            self.within_bounds(parts[part], {name: column})
        system = ridden(*parts.values())
        places = dict(zip(parts, system.parts, strict=True))
        columns = {f"{places[part]}.{name}": column for (part, name), column in values.items()}

        def linearised(member: np.ndarray, speed: np.ndarray) -> StateSpace:
            return linearise(system, **{"vehicle.speed": speed}, **{n: x[member] for n, x in columns.items()})

        return linearised

    @staticmethod
    def within_bounds(part: Part, values: Mapping[str, Any]) -> None:
        """Raises InputError for values (n,) outside their bounds."""
        for name, column in values.items():
            for extreme in (np.min(column), np.max(column)):
                in_bounds(extreme, part.table[name], part.name)

    def _one_by_one(self, runs: Sequence[Sequence[Part]]) -> StackedLinearised:
        """A system for each run: where FMUs take part, or a rider who leans changes the vehicle."""

        def linearised(member: np.ndarray, speed: np.ndarray) -> StateSpace:
            spaces: dict[int, StateSpace] = {k: _linearised(runs[k], speed[member == k]) for k in np.unique(member)}
            first = next(iter(spaces.values()))
            matrices = {name: np.empty((len(member), *getattr(first, name).shape[1:])) for name in "ABCD"}
            for k, space in spaces.items():
                for name, matrix in matrices.items():
                    matrix[member == k] = getattr(space, name)
            return StateSpace(**matrices, states=first.states, inputs=first.inputs, outputs=first.outputs)

        return linearised


def _linearised(parts: Sequence[Part], speed: np.ndarray) -> StateSpace:
    """One run at speeds (n,) [m/s]."""
    components = [part for part in parts if isinstance(part, Component)]
    if len(components) == len(parts):
        return linearise(ridden(components[0], *components[1:]), **{"vehicle.speed": speed})
    vehicle, *devices = (GivenFmu(part.path(), part.changed) if isinstance(part, Archive) else part for part in parts)
    with ExitStack() as opened:
        fmus = {n: opened.enter_context(fmu) for n, fmu in ridden_fmus(vehicle, devices).items()}
        return over_speed_fmus(fmus)(speed)


def _limit(variable: ModelVariable, end: str, absent: float) -> float:
    """The bound `min` or `max` of a variable, or of its type, where one is stated."""
    every = (getattr(owner, end, None) for owner in (variable, variable.declaredType))
    return float(next((stated for stated in every if stated is not None), absent))


def groups(indices: np.ndarray) -> list[tuple[int, int, np.ndarray]]:
    """The runs of each vehicle and device: their two indices, and which rows of `indices` (n, dims) they are."""
    pairs = np.unique(indices[:, :2], axis=0)
    return [(int(v), int(d), np.flatnonzero((indices[:, 0] == v) & (indices[:, 1] == d))) for v, d in pairs]


def owner(parts: Mapping[str, Part], key: str) -> tuple[str, str]:
    """The part and the name of the parameter that `name` or `part.name` means. Raises InputError for any other."""
    values = {name: part.values for name, part in parts.items()}
    present = next((own[key] for own in values.values() if key in own), 0.0)
    ((part, (name,)),) = ((part, own) for part, own in by_part(values, {key: present}).items() if own)
    return part, name
