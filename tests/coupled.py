"""The cases in which couplings are judged: the mean rider on a bar of 0.6 kg.m2 and on a motorcycle."""

from functools import cache

import numpy as np

from fmus.cosimulation.cosimulate import join
from fmus.cosimulation.network import Network
from fmus.cosimulation.subsystems.subsystem import LinearSubsystem
from fmus.declaration.component import Component
from fmus.linear_analysis.linearisation import StateSpace, linearise
from rider_fmu import riders
from rider_fmu.rigs.handlebar import Handlebar
from vehicle_fmu import motorcycles, ridden

RIDER = riders.load("mean_2011")
BAR = Handlebar("bar", steer_inertia=0.6)
MOTORCYCLE = motorcycles.load("sharp_1971")


def carrying(vehicle: Component, rider: Component = RIDER) -> Component:
    """The vehicle with the rider's inertia at the bar, as `ridden` binds it."""
    ratio = rider.values["cross_inertia"] / rider.values["torso_inertia"]
    return vehicle.with_values(
        added_steer_inertia=rider.values["added_steer_inertia"] - ratio * rider.values["cross_inertia"]
    )


@cache
def spaces(speed: float | None, name: str = "mean_2011") -> dict[str, StateSpace]:
    """Vehicle (the bar without a speed) and a rider by name as device, linearised."""
    rider = riders.load(name)
    vehicle = linearise(BAR) if speed is None else linearise(carrying(MOTORCYCLE, rider), speed=speed)
    return {"vehicle": vehicle, "device": linearise(rider)}


def network(speed: float | None = None, rider: str = "mean_2011", **ability) -> Network:
    """The two as linear subsystems."""
    subsystems = {name: LinearSubsystem(space, **ability) for name, space in spaces(speed, rider).items()}
    return Network(subsystems, join(subsystems))


def exact_eigenvalues(speed: float | None = None) -> np.ndarray:
    """Of the one coupled system, which knows no coupling: oscillatory ones below 15 Hz, slow ones first [1/s]."""
    system = ridden(BAR if speed is None else MOTORCYCLE, RIDER) if speed is not None else None
    matrix = linearise(system, **{"vehicle.speed": speed}).A if system is not None else bar_matrix()
    values = np.linalg.eigvals(matrix)
    values = values[(values.imag > 1e-9 * np.abs(values)) & (values.imag < 2 * np.pi * 15)]
    return values[np.argsort(np.abs(values))]


def bar_matrix() -> np.ndarray:
    """Rider on the bar by hand: states delta, s, theta, Omega (eqs 1, 2, 5 of the 2011 paper)."""
    p, inertia = RIDER.values, BAR.values["steer_inertia"]
    ka, kt, ca, ct, it = (
        p[n] for n in ("arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping", "torso_inertia")
    )
    return np.array([[0, 1, 0, 0], [-ka / inertia, -ca / inertia, ka / inertia, ca / inertia],
                     [0, 0, 0, 1], [ka / it, ca / it, -(ka + kt) / it, -(ca + ct) / it]])  # fmt: skip
