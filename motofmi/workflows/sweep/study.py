"""The description of a study: what a TOML file or the arguments of `sweep` say, validated before anything runs."""

import hashlib
import json
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fmus.declaration.component import Component, in_bounds
from fmus.support.errors import InputError, unknown
from motofmi.studies.axes import values_of
from motofmi.studies.population import DESIGNS, Distribution, drawn
from motofmi.studies.runs import Coordinate
from motofmi.version import __version__
from motofmi.workflows import components
from motofmi.workflows.components import ComponentLike, DeviceSet, together
from motofmi.workflows.parts import GivenFmu
from motofmi.workflows.parts import parts as parts_of
from motofmi.workflows.sweep.kinds import KINDS
from motofmi.workflows.sweep.populations import PUBLISHED, RIDER, rider_population, uniform
from motofmi.workflows.sweep.system_runs import SystemRuns
from motofmi.workflows.sweep.systems import Archive, Part, Systems, Varied, owner

KEYS = ("kind", "vehicle", "device", "speed", "set", "count", "design", "seed")
SAMPLE = "sample"  # the dimension of a design without riders


@dataclass(frozen=True)
class Study:
    """A study: any product of vehicles, devices, speeds, parameter values and members of populations.

    kind is one of KINDS. set gives values by parameter (a number, a sequence, `A:B:N`), a population `~NAME` of riders
    under the name `rider`, or a range `~A:B` of a parameter; count members are drawn by the design (`sobol`,
    `latin_hypercube`, `random`, or `members` for the published riders themselves). options are those of the kind.
    """

    kind: str = "modes"
    vehicle: Sequence[ComponentLike] = ("sharp_1971",)
    device: Sequence[DeviceSet] = (None,)
    speed: Any = None
    set: Mapping[str, Any] = field(default_factory=dict)
    count: int = 100
    design: str = DESIGNS[0]
    seed: int = 0
    options: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def read(cls, path: str | Path, **changed: Any) -> "Study":
        """The study of a TOML file, with some keys changed. Raises InputError for a file that cannot be read."""
        try:
            contents = tomllib.loads(Path(path).read_text("utf-8"))
        except OSError as error:
            raise InputError(f"cannot read {path}: {error.strerror}") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise InputError(f"{path} is not a valid TOML file: {error}") from None
        return cls.of({**contents, **changed})

    @classmethod
    def of(cls, contents: Mapping[str, Any]) -> "Study":
        """The study of a mapping with KEYS and the options of its kind. Raises InputError for any other key."""
        kind = contents.get("kind", "modes")
        if kind not in KINDS:
            raise unknown("kind of study", kind, KINDS)
        options = KINDS[kind].OPTIONS
        for key in contents:
            if key not in (*KEYS, *options):
                raise unknown(f"key of a study of kind {kind}", key, (*KEYS, *options))
        given = {key: contents[key] for key in KEYS if key in contents}
        for key in ("vehicle", "device"):
            if key in given and (isinstance(given[key], str | Path | Component) or given[key] is None):
                given[key] = [given[key]]
        return cls(**given, options={key: contents[key] for key in options if key in contents})

    def runs(self) -> SystemRuns:
        """The runs of the study. Raises InputError for whatever cannot be run: unknown names, values outside bounds."""
        kind = KINDS[self.kind]
        vehicles, devices, names = self._systems()
        sampled = {name: text[1:] for name, text in self.set.items() if isinstance(text, str) and text[:1] == "~"}
        rider = rider_population(sampled.pop(RIDER)) if RIDER in sampled else None
        systems = Systems(vehicles, devices, None if rider is None else rider.component, ())
        systems.check()
        axes: dict[str, Coordinate] = {}
        varied: list[Varied] = []
        if rider is not None or sampled:
            distributions: list[Distribution] = [] if rider is None else [rider.distribution]
            owners = {name: _owner(systems, name) for name in sampled}
            units = {name: _row(systems, *owners[name]).unit for name in sampled}
            distributions += [uniform(name, text, units[name]) for name, text in sampled.items()]
            drawn_values = drawn(distributions, self.count, self.design, self.seed)
            dim = SAMPLE if rider is None else RIDER
            axes[dim] = Coordinate(dim, np.arange(1, len(drawn_values[0]) + 1), "1", "number of the member")
            for distribution, values in zip(distributions, drawn_values, strict=True):
                for name, column in zip(distribution.names, values.T, strict=True):
                    varied.append(Varied(2, *owners.get(name, (RIDER, name)), column))
        for name, given in self.set.items():
            if isinstance(given, str) and given[:1] == "~":
                continue
            part, parameter = _owner(systems, name)
            row, values = _row(systems, part, parameter), values_of(name, given)
            for value in values:
                in_bounds(value, row, part)
            axes[name] = Coordinate(name, values, row.unit, row.description)
            varied.append(Varied(1 + len(axes), part, parameter, values))
        options = kind.checked(self, systems)
        systems = Systems(vehicles, devices, systems.rider, tuple(varied))
        axes |= kind.axes_of(options)
        parameters = {_column(v, axes): (v.dim, v.values, _row(systems, v.part, v.name).unit) for v in varied}
        parameters |= {n: (2 + list(axes).index(n), _array(a.values), a.unit) for n, a in axes.items()
                       if n not in parameters}  # fmt: skip
        return kind(systems, names, axes, parameters, options)

    def _systems(self) -> tuple[list[Part], list[list[Part]], dict[str, list[str]]]:
        """Vehicles, sets of devices, and their labels."""
        vehicles: list[Part] = []
        devices: list[list[Part]] = []
        needs_vehicle = KINDS[self.kind].VEHICLE
        for given in self.vehicle if needs_vehicle else ():
            whole, _ = parts_of(given)
            vehicles.append(_carried(whole))
        sets = [together(given) for given in self.device]
        for held in sets:
            if needs_vehicle:
                _, found = parts_of(self.vehicle[0], held)
                devices.append([_carried(part) for part in found])
            else:
                devices.append([part for each in held if (part := components.device(each)) is not None])
        names = {"vehicle": [_label([v]) for v in self.vehicle] if needs_vehicle else ["none"],
                 "device": [_label(held) for held in sets]}  # fmt: skip
        for dim, labels in names.items():
            for label in labels:
                if labels.count(label) > 1:
                    raise InputError(f"the {dim} {label!r} is given twice")
            if not labels:
                raise InputError(f"no {dim}: give at least one")
        return vehicles, devices, names

    def description(self, runs: SystemRuns) -> dict[str, Any]:
        """What the results depend on, with a hash of it: values of all components, versions, the grid."""
        systems = runs.systems
        contents = {
            "kind": self.kind,
            "vehicle": [_contents(part) for part in systems.vehicles],
            "device": [[_contents(part) for part in held] for held in systems.devices],
            "rider": None if systems.rider is None else _contents(systems.rider),
            "labels": runs.names,
            "axes": {name: _array(axis.values).tolist() for name, axis in runs.axes.items()},
            "varied": {f"{v.part}.{v.name}": [float(x) for x in v.values] for v in systems.varied},
            "options": runs.stated(),
            "set": {name: str(given) for name, given in self.set.items()},
            "count": self.count, "design": self.design, "seed": self.seed,
            "chunk": list(runs.grid.chunk),
            "version": __version__,
        }  # fmt: skip
        text = json.dumps(contents, sort_keys=True)
        return {**contents, "hash": hashlib.sha256(text.encode()).hexdigest()}


def _label(parts: Sequence[ComponentLike | None]) -> str:
    return ",".join("none" if p is None else p.name if isinstance(p, Component) else str(p) for p in parts) or "none"


def _carried(part: Component | GivenFmu) -> Part:
    return Archive.of(part.path) if isinstance(part, GivenFmu) else part


def _contents(part: Part) -> dict[str, Any]:
    """What identifies a part: the structure of its equations and its values, or the hash of its archive."""
    if isinstance(part, Archive):
        return {"name": part.name, "sha256": part.sha256}
    return {"name": part.name, "component": part.title, "effects": [type(e).__name__ for e in part.effects],
            "values": {name: float(value) for name, value in part.values.items()}}  # fmt: skip


def _owner(systems: Systems, key: str) -> tuple[str, str]:
    """The part and the name of a parameter, the same in every system. Raises InputError where a system lacks it."""
    found = set()
    for vehicle in range(max(len(systems.vehicles), 1)):
        for device in range(len(systems.devices)):
            found.add(owner(systems.parts(vehicle, device), key))
    if len(found) > 1:
        raise InputError(f"{key!r} belongs to different parts ({', '.join(sorted(p for p, _ in found))}): write "
                         f"{min(found)[0]}.{key}")  # fmt: skip
    return found.pop()


def _row(systems: Systems, part: str, name: str) -> Any:
    return systems.parts(0, 0)[part].table[name]


def _array(values: Any) -> np.ndarray:
    """Names as text, anything else as numbers."""
    found = np.asarray(values)
    return found if found.dtype.kind == "U" else found.astype(float)


def _column(varied: Varied, axes: Mapping[str, Coordinate]) -> str:
    """The column of a varied parameter: the name under which it was set, or that of the part and the parameter."""
    full = f"{varied.part}.{varied.name}"
    return next((n for n in (full, varied.name) if n in axes), full)


__all__ = ["PUBLISHED", "Study"]
