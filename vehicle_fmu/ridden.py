"""A vehicle with a device at its handlebar, as one system, and as a function of speed."""

import numpy as np

from fmus.component import Component
from fmus.linear import StateSpace, linearise
from fmus.system import System
from vehicle_fmu.mode_names import Linearised


def ridden(vehicle: Component, device: Component | None = None) -> System:
    """The vehicle with a device (a rider, a damper) at its handlebar port, or alone.

    A rider's inertia that moves with the handlebar becomes the vehicle's `added_steer_inertia`.
    """
    if device is None:
        return System(vehicle.name, {"vehicle": vehicle})
    bindings = {"vehicle.added_steer_inertia": "device.port_inertia"} if "port_inertia" in device.table else {}
    return System(f"{vehicle.name}_{device.name}", {"vehicle": vehicle, "device": device}, bindings=bindings)


def over_speed(system: System) -> Linearised:
    """The system linearised about straight running, as a function of speeds (n,) in m/s."""

    def linearised(speeds: np.ndarray) -> StateSpace:
        return linearise(system, **{"vehicle.speed": speeds})

    return linearised
