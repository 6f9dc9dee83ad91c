"""The rider as fitted, with the effects found: his value file, which every command accepts, and his FMU."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fmus.composition.value_files import value_file
from fmus.declaration.component import Component
from fmus.effects import Effect
from fmus.linear_analysis.describing_function import change_by_motion
from fmus.linear_analysis.linearisation import StateSpace
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.estimation.fit_result import Fit, parameters_of
from motofmi.gap.models.collocation import Motion
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.simulation import simulate
from motofmi.workflows.gap.fitted_model import FittedModel, of_value_file
from rider_fmu import riders
from vehicle_fmu import modes, motorcycles, over_speed, ridden

FILE = "augmented_rider.toml"
PREFIX = "device."  # of the rider's parameters in the system of handlebar and rider
HANDLEBAR_MOTION = ("steer_angle", "steer_rate")
MOTION_POINTS = 500  # of each run, over which the describing functions are averaged
SPEEDS = np.arange(10.0, 60.1, 10.0)  # m/s, at which the modes before and after are compared


def device_effects(found: Fit) -> list[type[Effect]]:
    """The effects that belong to the rider; those of the measuring channel belong to the rig."""
    return [e for e in found.model.effects if e.part == "device"]


def fitted_rider(
    found: Fit, source: str, effects_folder: str | None = None, own_effects: Sequence[type[Effect]] = ()
) -> FittedModel:
    """The rider as fitted, with the effects found. effects_folder is the folder of a user's own effects, or None."""
    fitted = {n.removeprefix(PREFIX): entry for n, entry in parameters_of(found).items() if n.startswith(PREFIX)}
    text = value_file("PassiveRider", fitted, "Rider as fitted to recordings, with the effects of the best model",
                      source, device_effects(found), effects_folder=effects_folder)  # fmt: skip
    return of_value_file(FILE, text, own_effects)


def rider_of(found: Fit) -> Component:
    """The rider with the values of a fit without effects."""
    values = {
        n.removeprefix(PREFIX): value for n, (value, _, _) in parameters_of(found).items() if n.startswith(PREFIX)
    }
    return riders.load("mean_2011").with_values(**values)


def motion_of(found: Fit, rider: Component) -> dict[str, np.ndarray]:
    """Motion of handlebar and rider in the fitted runs, simulated with the fitted rider.

    Values (n,) of the steer angle [rad], its rate [rad/s] and the rider's states, by their names in the ridden vehicle.
    Empty if the rider cannot be simulated with his delays as states.
    """
    equations, points = Equations(rider, rider.outputs, ()), []
    for run in found.runs:
        middles = (run.nodes[1:] + run.nodes[:-1]) / 2
        at, between = (
            {**dict.fromkeys(rider.inputs, 0.0), **dict(zip(HANDLEBAR_MOTION, run.motion_at(t), strict=False))}
            for t in (run.nodes, middles)
        )
        try:
            states = simulate(equations, rider.start_values(), Motion(run.nodes, at, between)).states
        except InputError:
            return {}
        points.append(np.column_stack([at[n] for n in HANDLEBAR_MOTION]
                                      + [states])[:: max(len(states) // MOTION_POINTS, 1)])
    names = [*(f"vehicle.{n}" for n in HANDLEBAR_MOTION), *(f"device.{n}" for n in rider.states)]
    return dict(zip(names, np.concatenate(points).T, strict=True))


def effect_on_modes(
    base: Component, augmented: Component, motion: Mapping[str, np.ndarray] | None = None, vehicle: str = "sharp_1971"
) -> dict[str, Any]:
    """Frequency [Hz] and damping ratio of weave, wobble and rider-wobble over speed [m/s].

    Keys: `before` without the effects found, `after` with them, linearised at rest, and `in_motion` with them,
    linearised by describing functions over a motion (see `motion_of`), if one is given.
    """
    without, with_it = (ridden(motorcycles.load(vehicle), rider) for rider in (base, augmented))
    linearised = {"before": over_speed(without), "after": over_speed(with_it)}
    if motion:
        change = change_by_motion(with_it, motion, **{"vehicle.speed": SPEEDS[0]})  # of the rider: at all speeds
        linearised["in_motion"] = lambda speeds: _changed(linearised["after"](speeds), change)

    def found(labels: Sequence[str]) -> dict[str, Any]:
        each = {label: modes(linearised[label], SPEEDS) for label in labels}
        return {label: {name: _mode(m[name]) for name in ("weave", "wobble", "rider_wobble")}
                for label, m in each.items()}  # fmt: skip

    # The equations of a rider are differentiated once in each process.
    without_effects, with_effects = parallel_map(found, [("before",), tuple(linearised)[1:]], "modes")
    return {"speed": SPEEDS.tolist(), **without_effects, **with_effects}


def _changed(rest: StateSpace, change: np.ndarray) -> StateSpace:
    return replace(rest, A=rest.A + change)


def _mode(mode: Any) -> Mapping[str, Any]:
    return {"frequency": list(mode.frequency), "damping_ratio": list(mode.damping_ratio)}
