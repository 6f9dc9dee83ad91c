"""The vehicle as fitted, with the effects that were found: a value file that every command takes, and its FMU."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fmus.build import build
from fmus.component import Component
from fmus.library import value_file
from identification.gap.models.disturbances import FAMILY
from identification.gap.naming.fitted import Fit, parameters_of
from scenarios import names
from scenarios.command_line import write_text
from vehicle_fmu import MODES, modes, over_speed, ridden

FILE = "augmented_vehicle.toml"
PREFIX, DEVICE = "vehicle.", "device."


def fitted_of(found: Fit) -> Mapping[str, tuple[float, float, str]]:
    """Value, standard error and unit of everything that was fitted, but of what disturbs the vehicle."""
    return {n: entry for n, entry in parameters_of(found).items() if not n.removeprefix(PREFIX).startswith(f"{FAMILY}.")}


def values_of(found: Fit) -> Mapping[str, tuple[float, float, str]]:
    """Value, standard error and unit of the vehicle's fitted parameters, those of its effects among them."""
    return {n.removeprefix(PREFIX): entry for n, entry in fitted_of(found).items() if not n.startswith(DEVICE)}


def write_vehicle(vehicle: Component, found: Fit, folder: Path, source: str, effects_folder: str | None = None) -> tuple[str, str]:
    """Write the vehicle of a fit and its FMU into the folder; their names there."""
    fitted = values_of(found)
    given: dict[str, tuple[float, float | None, str]] = {n: (value, None, vehicle.table[n].unit) for n, value in vehicle.values.items() if n not in fitted}
    text = value_file(vehicle.title, given | dict(fitted), f"{vehicle.name} as fitted to measurements, with what it lacked", source,
                      found.model.effects, effects_folder=effects_folder)  # fmt: skip
    write_text(folder / FILE, text)
    fmu = build(names.component(str(folder / FILE)), folder)
    return FILE, Path(fmu.path).name


def vehicle_of(vehicle: Component, found: Fit) -> Component:
    """The vehicle with the base parameters of a fit without effects."""
    return vehicle.with_values(**{n: value for n, (value, _, _) in values_of(found).items() if n in vehicle.values})


def effect_on_modes(before: Component, after: Component, device: Component | None, speeds: np.ndarray) -> dict[str, Any]:
    """Frequency [Hz] and damping ratio of every mode that is there over speed, without and with what was found."""
    found = {label: modes(over_speed(ridden(v, device)), speeds) for label, v in (("before", before), ("after", after))}
    there = [m for m in MODES if any(not np.isnan(each[m].eigenvalue).all() for each in found.values())]
    return {"speed": speeds.tolist(),
            **{label: {m: {"frequency": list(each[m].frequency), "damping_ratio": list(each[m].damping_ratio)} for m in there}
               for label, each in found.items()}}  # fmt: skip
