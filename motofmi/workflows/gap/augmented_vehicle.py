"""The vehicle as fitted, with the effects found: its value file, which every command accepts, and its FMU."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmus.composition.value_files import value_file
from fmus.declaration.component import Component
from fmus.effects import Effect
from motofmi.gap.estimation.fit_result import Fit, parameters_of
from motofmi.gap.models.disturbances import FAMILY
from motofmi.workflows import components
from motofmi.workflows.gap.fitted_model import FittedModel, of_value_file
from vehicle_fmu import MODES, modes, over_speed, ridden

FILE, DEVICE_FILE = "augmented_vehicle.toml", "fitted_device.toml"
PREFIX, DEVICE = "vehicle.", "device."  # of parameters in the system of vehicle and device


def fitted_of(found: Fit) -> Mapping[str, tuple[float, float, str]]:
    """Value, standard error and unit of every fitted parameter by name, without those of the disturbances."""
    return {
        n: entry for n, entry in parameters_of(found).items() if not n.removeprefix(PREFIX).startswith(f"{FAMILY}.")
    }


def values_of(found: Fit) -> Mapping[str, tuple[float, float, str]]:
    """Value, standard error and unit of the fitted parameters of the vehicle and of its effects, by name."""
    return {n.removeprefix(PREFIX): entry for n, entry in fitted_of(found).items() if not n.startswith(DEVICE)}


def fitted_vehicle(vehicle: Component, found: Fit, source: str, effects_folder: str | None = None,
                   own_effects: Sequence[type[Effect]] = ()) -> FittedModel:  # fmt: skip
    """The vehicle as fitted, with the effects found. effects_folder is the folder of a user's own effects, or None."""
    fitted = values_of(found)
    given: dict[str, tuple[float, float | None, str]] = {
        n: (value, None, vehicle.table[n].unit) for n, value in vehicle.values.items() if n not in fitted
    }
    text = value_file(vehicle.title, given | dict(fitted), f"{vehicle.name} as fitted to measurements, with the "
                                                           "effects of the best model", source,
                      found.model.effects, effects_folder=effects_folder)  # fmt: skip
    return of_value_file(FILE, text, own_effects)


def fitted_device(found: Fit, source: str) -> FittedModel | None:
    """The device among the effects found, as a component with a value file of its own, or None."""
    devices = {(e.family, e.form): e for e in components.DEVICE_EFFECTS}
    for effect in found.model.effects:
        if (effect.family, effect.form) in devices:
            device = devices[effect.family, effect.form]
            fitted = values_of(found)
            parameters = {n: fitted[f"{effect.family}.{n}"] for n in effect.free_parameters()}
            component = device.with_values({n: value for n, (value, _, _) in parameters.items()}, "fitted_device",
                                           source)
            given: dict[str, tuple[float, float | None, str]] = {
                n: (value, None, component.table[n].unit)
                for n, value in component.values.items() if n not in parameters
            }
            text = value_file(component.title, given | parameters, f"{component.title} as fitted on a vehicle", source)
            return FittedModel(component, DEVICE_FILE, text)
    return None


def vehicle_of(vehicle: Component, found: Fit) -> Component:
    """The vehicle with the values of a fit without effects."""
    return vehicle.with_values(**{n: value for n, (value, _, _) in values_of(found).items() if n in vehicle.values})


def effect_on_modes(
    before: Component, after: Component, device: Component | None, speeds: np.ndarray
) -> dict[str, Any]:
    """Frequency [Hz] and damping ratio of every named mode over speeds (n,) [m/s], without and with the effects found.

    A mode that is found at none of the speeds is left out.
    """
    found = {label: modes(over_speed(ridden(v, device)), speeds) for label, v in (("before", before), ("after", after))}
    present = [m for m in MODES if any(not np.isnan(each[m].eigenvalue).all() for each in found.values())]
    return {"speed": speeds.tolist(),
            **{label: {m: {"frequency": list(each[m].frequency), "damping_ratio": list(each[m].damping_ratio)}
                       for m in present}
               for label, each in found.items()}}  # fmt: skip
