"""A vehicle with devices at its ports (a rider, a damper, a rider who leans), as one system, and as a function of speed.

What of a rider moves with the vehicle is bound to it: his inertia at the handlebar, `port_inertia`, becomes the vehicle's
`added_steer_inertia`, and where it changes with posture the vehicle carries that, too. A rider who leans brings his mass himself, and the vehicle's rear frame is lightened by it.
"""

from collections.abc import Collection, Iterable
from typing import TypeVar

import numpy as np

from fmus.component import Component
from fmus.errors import InputError
from fmus.linear import StateSpace, linearise
from fmus.mathematics import NUMERIC
from fmus.posture import POSTURE, CarriesPosture
from fmus.system import System
from vehicle_fmu.lightened import BODY, lightened
from vehicle_fmu.mode_names import Linearised

Part = TypeVar("Part")


def ridden(vehicle: Component, *devices: Component | None) -> System:
    """The vehicle with devices at its ports, or alone; devices that are None are left out.

    Its parts are `vehicle`, `device`, `device_2` and so on. Raises InputError when the vehicle cannot spare the mass of
    a rider who leans, or when two riders hold the handlebar.
    """
    held = [device for device in devices if device is not None]
    for body in map(rigid_body, held):
        vehicle = lightened(vehicle, *body) if body else vehicle
    vehicle = carrying(vehicle, {name for device in held for name in device.outputs})
    parts = {"vehicle": vehicle, **by_name(held)}
    at_the_bar = [part for part, c in parts.items() if "port_inertia" in c.table]
    if len(at_the_bar) > 1:
        raise InputError(f"{' and '.join(parts[part].name for part in at_the_bar)} cannot both hold the handlebar; give one rider there")
    bindings = {"vehicle.added_steer_inertia": f"{at_the_bar[0]}.port_inertia"} if at_the_bar else {}
    return System("_".join(c.name for c in (vehicle, *held)), parts, bindings=bindings)


def carrying(vehicle: Component, answered: Collection[str]) -> Component:
    """The vehicle, which carries a rider's inertia as it changes with his posture where that is answered."""
    return vehicle.with_effects(CarriesPosture()) if set(POSTURE) <= set(answered) else vehicle


def by_name(devices: Iterable[Part]) -> dict[str, Part]:
    """The devices as parts of a system: `device`, `device_2` and so on."""
    return {"device" if k == 1 else f"device_{k}": device for k, device in enumerate(devices, start=1)}


def rigid_body(device: Component) -> list[float]:
    """Mass [kg], height [m] and roll inertia [kg.m2] of a rider who leans, held stiff; [] for any other device."""
    if not set(BODY) <= device.table.keys():
        return []
    results = device.run(device.start_values(), NUMERIC)
    return [float(results[name]) for name in BODY]


def over_speed(system: System) -> Linearised:
    """The system linearised about straight running, as a function of speeds (n,) in m/s."""

    def linearised(speeds: np.ndarray) -> StateSpace:
        return linearise(system, **{"vehicle.speed": speeds})

    return linearised
