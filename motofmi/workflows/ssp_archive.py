"""A vehicle with devices at its ports as an SSP archive.

The parameters and starts are built into the FMUs, because some tools do not read the bindings of an archive, and bound
in the archive as well, where they can be read and changed.
"""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from fmus.cosimulation.cosimulate import join
from fmus.cosimulation.ssp import write_ssp
from fmus.declaration.component import Component, in_bounds
from fmus.export.build import BuiltFmu, build
from fmus.support.errors import InputError
from motofmi.workflows.components import ComponentLike, component
from motofmi.workflows.parts import Part, parts, role_of
from motofmi.workflows.ridden_fmus import ridden_fmus
from vehicle_fmu.ridden import by_name, with_posture_inertia

SPEED = 30.0  # m/s; the default


def build_ssp(given: Sequence[ComponentLike], path: Path, version: int | str = 1, *, fmi: int = 2,
              backend: str = "compiled", platforms: str = "host", set: Mapping[str, float] | None = None,
              initial: Mapping[str, float] | None = None, speed: float = SPEED) -> list[BuiltFmu]:  # fmt: skip
    """Write the archive of one vehicle and its devices; its FMUs.

    set and initial are as in `cosimulate`, speed is in m/s. Raises InputError when not exactly one vehicle is given,
    and for several devices at one port, since an SSP has no sums.
    """
    vehicle, devices = _roles(given)
    whole, held = parts(vehicle, devices, set)
    subsystems = ridden_fmus(whole, held, initial, speed)
    try:
        wiring = join(subsystems)
        values = {name: {**_parameters(part), **fmu.values} for part, (name, fmu)
                  in zip((whole, *held), subsystems.items(), strict=True)}  # fmt: skip
    finally:
        for fmu in subsystems.values():
            fmu.close()
    if isinstance(whole, Component):
        whole = with_posture_inertia(whole, {name for fmu in list(subsystems.values())[1:] for name in fmu.outputs})
    every: dict[str, Part] = {"vehicle": whole, **by_name(held)}
    with tempfile.TemporaryDirectory() as folder:
        built = {name: build(started(part, values[name]), Path(folder, name), fmi, backend, platforms)
                 for name, part in every.items() if isinstance(part, Component)}  # fmt: skip
        files = {n: built[n].path if isinstance(part, Component) else part.path for n, part in every.items()}
        write_ssp(path, files, wiring, values, version)
    return [replace(each, path=path) for each in built.values()]


def _roles(given: Sequence[ComponentLike]) -> tuple[ComponentLike, list[ComponentLike]]:
    """The vehicle and the devices among components, names and paths."""
    vehicles = [each for each in given if _is_vehicle(each)]
    if len(vehicles) != 1:
        raise InputError(
            f"an .ssp holds one vehicle and the devices at its ports, but {len(vehicles) or 'no'} vehicle"
            f"{'s are' if len(vehicles) > 1 else ' is'} given: name one, as in motofmi build sharp_1971 "
            "rider:mean_2011 --ssp ridden.ssp"
        )
    return vehicles[0], [each for each in given if each is not vehicles[0]]


def _is_vehicle(given: ComponentLike) -> bool:
    if not isinstance(given, Component) and Path(given).suffix == ".fmu":
        return role_of(given) == "vehicle"
    return "speed" in component(given).inputs


def _parameters(part: Part) -> dict[str, float]:
    return dict(part.values) if isinstance(part, Component) else {}


def started(part: Component, values: Mapping[str, float | int | bool | str]) -> Component:
    """The component with other parameters, and other starts of states and inputs."""
    twin = part.with_values(**{n: float(x) for n, x in values.items() if n in part.values})
    for name, value in values.items():
        row = twin.table[name]
        if row.role != "parameter":
            twin.table[name] = replace(row, start=in_bounds(value, row, part.name))
    return twin
