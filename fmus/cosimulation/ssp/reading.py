"""The FMUs of an SSP archive, initialised with the values that are bound to them, and their wiring."""

import warnings
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Self

import numpy as np

from fmus.cosimulation.network import Network
from fmus.cosimulation.ssp.converter import Converter
from fmus.cosimulation.ssp.flattening import Flat, flatten
from fmus.cosimulation.ssp.package import Package
from fmus.cosimulation.ssp.structure import read_structure
from fmus.cosimulation.ssp.units import IDENTITY
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.cosimulation.subsystems.stated_units import by_fmu
from fmus.cosimulation.subsystems.subsystem import Subsystem
from fmus.support.errors import InputError, unknown

SHOWN = 5  # ignored values that a warning names


@dataclass(repr=False)
class SspSystem:
    """A system of FMUs from an archive; a context manager that frees them.

    fmus by name, nested systems joined by slashes (`front/damper`); converters are the connections with a conversion of
    units or a linear transformation; wiring is input -> [output]; start and stop [s] are those of the default
    experiment, stop None where there is none.
    """

    path: Path
    fmus: dict[str, FmuSubsystem]
    converters: dict[str, Converter]
    wiring: dict[str, list[str]]
    start: float
    stop: float | None
    _opened: ExitStack

    @property
    def subsystems(self) -> dict[str, Subsystem]:
        """FMUs and converters, as a coupling steps them."""
        return {**self.fmus, **self.converters}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    @property
    def duration(self) -> float | None:
        """The duration [s] of the default experiment; None where it has no end."""
        return None if self.stop is None or not self.stop > self.start else self.stop - self.start

    def __repr__(self) -> str:
        return f"<SspSystem {self.path}: {', '.join(self.fmus)}>"

    def close(self) -> None:
        """Free the FMUs; calling it again does nothing."""
        self._opened.close()


def read_ssp(path: str | Path, changed: Mapping[str, float] | None = None,
             units: Mapping[str, str] | None = None) -> SspSystem:  # fmt: skip
    """The system in an SSP archive, initialised; `changed` replaces values by `fmu.variable`, `units` states units of
    variables that have none.

    Raises InputError with file, element and reason for what cannot be read, and for what is not supported. Values that
    are bound to names that no element has are ignored, as the standard has it, with a warning.

        with read_ssp("ridden.ssp") as system:
            cosimulate(system.subsystems, 1e-3, 5.0, wiring=system.wiring)
    """
    with ExitStack() as opened:
        folder = opened.enter_context(TemporaryDirectory(prefix="ssp-"))
        with Package(path, folder) as package:
            structure = read_structure(package)
            flat = flatten(structure.system, package)
        if flat.ignored:
            more = f" and {len(flat.ignored) - SHOWN} more" if len(flat.ignored) > SHOWN else ""
            warnings.warn(
                f"{path}: values are bound to {', '.join(flat.ignored[:SHOWN])}{more}, which no element has; they are "
                "ignored",
                stacklevel=2,
            )
        _change(flat, changed or {})
        stated = by_fmu(units or {}, {name: c.variables for name, c in flat.components.items()})
        fmus = {
            name: opened.enter_context(FmuSubsystem(c.file, name, flat.values[name], units=stated[name]))
            for name, c in flat.components.items()
        }
        wiring, converters = _wired(flat)
        subsystems: dict[str, Subsystem] = {**fmus, **converters}
        network = Network(subsystems, wiring)
        network.read(np.zeros(len(network.outputs)))  # sets every input to the output that drives it
        return SspSystem(
            Path(path), fmus, converters, wiring, structure.start, structure.stop, opened.pop_all()
        )


def _change(flat: Flat, changed: Mapping[str, float]) -> None:
    """Replace values by `fmu.variable`, or by a variable that one FMU has."""
    settable = {
        f"{name}.{v.name}" for name, c in flat.components.items() for v in c.description.modelVariables
        if v.causality in ("parameter", "input") or v.initial == "exact"
    }  # fmt: skip
    for key, value in changed.items():
        matching = [key] if key in settable else [s for s in settable if s.partition(".")[2] == key]
        if len(matching) > 1:
            raise InputError(f"{key!r} is a variable of {' and '.join(sorted(m.partition('.')[0] for m in matching))}: "
                             f"write {min(matching)}={value:g}")  # fmt: skip
        if not matching:
            raise unknown("variable", key, settable)
        name, _, variable = matching[0].partition(".")
        flat.values[name][variable] = value


def _wired(flat: Flat) -> tuple[dict[str, list[str]], dict[str, Converter]]:
    """The wiring, with a converter in each connection that changes its value."""
    wiring: dict[str, list[str]] = {}
    converters: dict[str, Converter] = {}
    for (name, variable), ((source, output), change) in flat.wires.items():
        target = f"{name}.{variable}"
        wiring[target] = [f"{source}.{output}"]
        if change != IDENTITY:
            own = f"{name}/{variable}"
            ends = (flat.components[source].variables[output], flat.components[name].variables[variable])
            converters[own] = Converter(change, (ends[0].unit or "", ends[1].unit or ""))
            wiring[f"{own}.given"], wiring[target] = wiring[target], [f"{own}.converted"]
    return wiring, converters
