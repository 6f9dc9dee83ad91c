"""A vehicle with devices at its ports (riders, dampers) as one system, and its linearisation over speed.

The inertia of a rider at the handlebar, `port_inertia`, is bound to the vehicle's `added_steer_inertia`; where it
changes with posture the vehicle gets the effect `PostureInertia`. The mass of a leaning rider is removed from the rear
frame.
"""

from collections.abc import Collection, Iterable
from typing import TypeVar

import numpy as np

from fmus.composition.system import System
from fmus.declaration.component import Component
from fmus.expressions.functions import NUMERIC
from fmus.interfaces.posture_inertia import POSTURE, PostureInertia
from fmus.linear_analysis.linearisation import StateSpace, linearise
from fmus.support.errors import InputError
from vehicle_fmu.mode_shapes import Linearised
from vehicle_fmu.rider_mass_removed import RIDER_BODY, without_rider_mass

Part = TypeVar("Part")


def ridden(vehicle: Component, *devices: Component | None) -> System:
    """The vehicle with devices at its ports, or alone; devices that are None are ignored.

    The parts are `vehicle`, `device`, `device_2` and so on. Raises InputError when the rear frame does not contain the
    mass of a leaning rider, and when two riders hold the handlebar.

        ridden(motorcycles.load("sharp_1971"), riders.load("mean_2011"))
    """
    held = [device for device in devices if device is not None]
    for body in map(rigid_body, held):
        vehicle = without_rider_mass(vehicle, *body) if body else vehicle
    vehicle = with_posture_inertia(vehicle, {name for device in held for name in device.outputs})
    parts = {"vehicle": vehicle, **by_name(held)}
    at_the_bar = [part for part, c in parts.items() if "port_inertia" in c.table]
    if len(at_the_bar) > 1:
        raise InputError(
            f"{' and '.join(parts[part].name for part in at_the_bar)} cannot both hold the handlebar; "
            "give one rider there"
        )
    bindings = {"vehicle.added_steer_inertia": f"{at_the_bar[0]}.port_inertia"} if at_the_bar else {}
    return System("_".join(c.name for c in (vehicle, *held)), parts, bindings=bindings)


def with_posture_inertia(vehicle: Component, outputs: Collection[str]) -> Component:
    """The vehicle with the effect `PostureInertia`, if the outputs of its devices contain the variables of that
    effect.
    """
    return vehicle.with_effects(PostureInertia()) if set(POSTURE) <= set(outputs) else vehicle


def by_name(devices: Iterable[Part]) -> dict[str, Part]:
    """The devices as parts of a system: `device`, `device_2` and so on."""
    return {"device" if k == 1 else f"device_{k}": device for k, device in enumerate(devices, start=1)}


def rigid_body(device: Component) -> list[float]:
    """Mass [kg], height [m] and roll inertia [kg.m2] of a leaning rider as a rigid body; [] for any other device."""
    if not set(RIDER_BODY) <= device.table.keys():
        return []
    results = device.run(device.start_values(), NUMERIC)
    return [float(results[name]) for name in RIDER_BODY]


def over_speed(system: System) -> Linearised:
    """The linearisation about straight running as a function of speeds (n,) [m/s], for `modes`."""

    def linearised(speeds: np.ndarray) -> StateSpace:
        return linearise(system, **{"vehicle.speed": speeds})

    return linearised
