"""The rider as fitted, with the effects that were found: a value file that every command takes, and its FMU."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from fmus.component import Component
from fmus.effects import Effect
from fmus.errors import InputError
from fmus.in_motion import linearise_in_motion
from fmus.library import value_file
from identification.gap.models.equations import Equations
from identification.gap.models.simulate import Motion, simulate
from identification.gap.naming.fitted import Fit, parameters_of
from rider_fmu import riders
from scenarios import names
from scenarios.command_line import write_text
from vehicle_fmu import modes, motorcycles, over_speed, ridden

FILE = "augmented_rider.toml"
PREFIX = "device."
BAR = ("steer_angle", "steer_rate")
POINTS = 500  # of each run's motion
SPEEDS = np.arange(10.0, 60.1, 10.0)


def device_effects(found: Fit) -> list[type[Effect]]:
    """The effects that belong to the rider; those of the measuring channel stay with the rig."""
    return [e for e in found.model.effects if e.part == "device"]


def write_model(found: Fit, folder: Path, source: str, effects_folder: str | None = None) -> Component:
    """Write the rider as fitted into FILE in the folder; what the file holds."""
    fitted = {n.removeprefix(PREFIX): entry for n, entry in parameters_of(found).items() if n.startswith(PREFIX)}
    text = value_file("PassiveRider", fitted, "Rider as fitted to recordings, with what his model lacked", source,
                      device_effects(found), effects_folder=effects_folder)  # fmt: skip
    write_text(folder / FILE, text)
    return names.component(str(folder / FILE))


def rider_of(found: Fit) -> Component:
    """The rider of a fit without effects."""
    values = {n.removeprefix(PREFIX): value for n, (value, _, _) in parameters_of(found).items() if n.startswith(PREFIX)}
    return riders.load("mean_2011").with_values(**values)


def motion_of(found: Fit, rider: Component) -> dict[str, np.ndarray]:
    """How bar and rider move in the fitted runs: points (n,) of the steer angle, its rate and the rider's states, by their names on the vehicle.

    Empty where the rider cannot be simulated with his delays as states.
    """
    equations, moved = Equations(rider, rider.outputs, ()), []
    for run in found.runs:
        middles = (run.nodes[1:] + run.nodes[:-1]) / 2
        at, between = ({**dict.fromkeys(rider.inputs, 0.0), **dict(zip(BAR, run.moved(t), strict=False))} for t in (run.nodes, middles))
        try:
            states = simulate(equations, rider.start_values(), Motion(run.nodes, at, between)).states
        except InputError:
            return {}
        moved.append(np.column_stack([at[n] for n in BAR] + [states])[:: max(len(states) // POINTS, 1)])
    names_of = [*(f"vehicle.{n}" for n in BAR), *(f"device.{n}" for n in rider.states)]
    return dict(zip(names_of, np.concatenate(moved).T, strict=True))


def effect_on_modes(base: Component, augmented: Component, motion: Mapping[str, np.ndarray] | None = None, vehicle: str = "sharp_1971") -> dict[str, Any]:
    """Frequency [Hz] and damping ratio of weave, wobble and rider-wobble over speed: without and with what was found, at rest and in motion."""
    without, with_it = (ridden(motorcycles.load(vehicle), rider) for rider in (base, augmented))
    found = {"before": modes(over_speed(without), SPEEDS), "after": modes(over_speed(with_it), SPEEDS)}
    if motion:
        found["in_motion"] = modes(lambda speeds: linearise_in_motion(with_it, motion, **{"vehicle.speed": speeds}), SPEEDS)
    return {"speed": SPEEDS.tolist(),
            **{label: {name: _mode(each[name]) for name in ("weave", "wobble", "rider_wobble")} for label, each in found.items()}}  # fmt: skip


def _mode(mode: Any) -> Mapping[str, Any]:
    return {"frequency": list(mode.frequency), "damping_ratio": list(mode.damping_ratio)}
