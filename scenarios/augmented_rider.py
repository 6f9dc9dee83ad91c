"""The rider as fitted, with the effects that were found: a value file that every command takes, and its FMU."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fmus.build import build
from fmus.component import Component
from fmus.effects import Effect
from fmus.library import value_file
from identification.gap.naming.decide import Verdict
from identification.gap.naming.fitting import Fit, parameters_of
from rider_fmu import riders
from scenarios import names
from scenarios.command_line import write_text
from vehicle_fmu import modes, motorcycles, over_speed, ridden

FILE = "augmented_rider.toml"
PREFIX = "device."
SPEEDS = np.arange(10.0, 60.1, 10.0)


def device_effects(found: Fit) -> list[type[Effect]]:
    """The effects that belong to the rider; those of the measuring channel stay with the rig."""
    return [e for e in found.model.effects if e.part == "device"]


def write_model(verdict: Verdict, folder: Path, source: str, effects_folder: str | None = None) -> tuple[str, str]:
    """Write the augmented rider and its FMU into the folder; their names there."""
    fitted = {n.removeprefix(PREFIX): entry for n, entry in parameters_of(verdict.best).items() if n.startswith(PREFIX)}
    text = value_file("PassiveRider", fitted, "Rider as fitted to recordings, with what his model lacked", source,
                      device_effects(verdict.best), effects_folder=effects_folder)  # fmt: skip
    write_text(folder / FILE, text)
    fmu = build(names.component(str(folder / FILE)), folder)
    return FILE, Path(fmu.path).name


def rider_of(found: Fit) -> Component:
    """The rider of a fit without effects."""
    values = {n.removeprefix(PREFIX): value for n, (value, _, _) in parameters_of(found).items() if n.startswith(PREFIX)}
    return riders.load("mean_2011").with_values(**values)


def effect_on_modes(base: Component, augmented: Component, vehicle: str = "sharp_1971") -> dict[str, Any]:
    """Frequency [Hz] and damping ratio of weave, wobble and rider-wobble over speed, without and with what was found."""
    found = {label: modes(over_speed(ridden(motorcycles.load(vehicle), rider)), SPEEDS) for label, rider in (("before", base), ("after", augmented))}
    return {"speed": SPEEDS.tolist(),
            **{label: {name: _mode(each[name]) for name in ("weave", "wobble", "rider_wobble")} for label, each in found.items()}}  # fmt: skip


def _mode(mode: Any) -> Mapping[str, Any]:
    return {"frequency": list(mode.frequency), "damping_ratio": list(mode.damping_ratio)}
