"""A vehicle for the gap workflow: its eigenvalues measured over speed, against the motorcycle with what is known of it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fmus.component import Component
from fmus.effects import Effect, load_folder
from fmus.effects.library import joining
from fmus.errors import unknown
from identification.gap.data.eigenvalues import Spectrum
from identification.gap.models.eigenvalue_model import shaped
from identification.gap.stands.linear_stand import LinearStand
from identification.gap.stands.test_stand import Free
from scenarios.names import VEHICLE_EFFECTS
from vehicle_fmu import MODES, modes, over_speed, ridden

# To how much a vehicle's data are usually known: weighed and measured lengths, and what a pendulum or a tyre rig gives.
KNOWN_TO = {"kg": 0.01, "m": 0.01, "rad": 0.01, "kg.m2": 0.05, "N/rad": 0.05, "N.m.s/rad": 0.05}
RELAXATION = 0.05  # of a relaxation length, which is no length that a ruler measures
CERTAIN = ("gravity",)
NOT_LINEAR = ("steering_friction",)  # has no eigenvalues; in measured ones it looks like a damper
OF_INPUTS = ("motor_gain", "channel_delay")  # do nothing to eigenvalues
OF_HANDS = ("steering_friction", "steer_stiffness", "steer_damping", "added_inertia", "motor_gain")  # what hands do to a handlebar as well


def uncertain(vehicle: Component, free: Sequence[str] = (), prefix: str = "vehicle.") -> tuple[Free, ...]:
    """The parameters of the base that are fitted: those in `free` without prior knowledge, every other positive one with it.

    A standard_error in the vehicle's file is what is known; elsewhere KNOWN_TO by its unit.
    """
    rows = vehicle.rows("parameter")
    for name in free:
        if name not in rows:
            raise unknown(f"parameter of {vehicle.name}", name, rows)
    found = []
    for name, row in rows.items():
        value = vehicle.values[name]
        usual = RELAXATION if "relaxation" in name else KNOWN_TO.get(row.unit, 0.0)
        error = vehicle.standard_error.get(name, usual * value)
        if name in free:
            found.append(Free(prefix + name))
        elif name not in CERTAIN and value > 0 and error > 0:
            found.append(Free(prefix + name, 0.0, value, error))
    return tuple(found)


def vehicle_stand(vehicle: Component, device: Component | None = None, free: Sequence[str] = ()) -> LinearStand:
    """The vehicle over its speed, with a device at the handlebar or alone."""
    return LinearStand(ridden(vehicle, device), "vehicle", "vehicle.speed", uncertain(vehicle, free))


def vehicle_effects(vehicle: Component, folder: str | None = None, linear: bool = False) -> list[type[Effect]]:
    """The effects that ship and that the vehicle has words for, and a user's own; without those that have no eigenvalues if `linear`."""
    every = VEHICLE_EFFECTS + (load_folder(folder) if folder else [])
    return [e for e in joining(vehicle, every) if not (linear and e.family in (*NOT_LINEAR, *OF_INPUTS))]


def with_names(run: Spectrum, stand: LinearStand) -> Spectrum:
    """The measured eigenvalues with the shapes that their modes have in the base; a name that it lacks says nothing."""
    mode = tuple(m.strip().lower().replace("-", "_").replace(" ", "_") for m in run.mode)
    at, place = np.unique(run.over, return_inverse=True)
    found = modes(over_speed(stand.component), at)  # type: ignore[arg-type]
    nominal = np.array([found[m].eigenvalue[k] if m in MODES else np.nan for m, k in zip(mode, place, strict=True)], complex)
    return shaped(replace(run, mode=mode), stand, nominal)
