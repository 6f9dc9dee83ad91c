"""A vehicle under test: what is known of its parameters, and the effects that it may lack."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fmus.declaration.component import Component
from fmus.effects import Effect
from fmus.effects.library import applicable_effects
from fmus.support.errors import unknown
from motofmi.gap.criteria import Criteria
from motofmi.gap.experiments.experiment import FreeParameter
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.models.eigenvalue_model import with_mode_shapes
from motofmi.gap.preprocessing.eigenvalues import MeasuredEigenvalues
from motofmi.workflows.components import VEHICLE_EFFECTS
from vehicle_fmu import MODES, GivenMatrices, modes, over_speed, ridden
from vehicle_fmu.components.given_matrices import COORDINATES, STATES

# To how much a vehicle's data are usually known: weighed and measured lengths, and what a pendulum or a tyre rig gives.
KNOWN_TO = {"kg": 0.01, "m": 0.01, "rad": 0.01, "kg.m2": 0.05, "N/rad": 0.05, "N.m.s/rad": 0.05}
RELAXATION = 0.05  # of a relaxation length, which is no length that a ruler measures
ALL = "all"  # in free: nothing is known of the base
CERTAIN = ("gravity",)
NOT_LINEAR = ("coulomb_friction",)  # has no eigenvalues; in measured ones it looks like a damper
OF_INPUTS = ("motor_gain", "channel_delay")  # do nothing to eigenvalues
OF_HANDS = (
    "coulomb_friction",
    "steer_stiffness",
    "steer_damping",
    "added_inertia",
    "motor_gain",
    "passive_rider",
)  # what hands do to a handlebar as well


def uncertain(vehicle: Component, free: Sequence[str] = (), prefix: str = "vehicle.") -> tuple[FreeParameter, ...]:
    """The parameters of the base that are fitted: those in `free` without prior knowledge, every
    other positive one with it.

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
            found.append(FreeParameter(prefix + name))
        elif name not in CERTAIN and value > 0 and error > 0:
            found.append(FreeParameter(prefix + name, 0.0, value, error))
    return tuple(found)


def vehicle_experiment(
    vehicle: Component, device: Component | None = None, free: Sequence[str] = ()
) -> VehicleOverSpeedExperiment:
    """The vehicle over its speed, with a device at the handlebar or alone."""
    return VehicleOverSpeedExperiment(ridden(vehicle, device), "vehicle", "vehicle.speed", uncertain(vehicle, free))


def vehicle_effects(vehicle: Component, own: Sequence[type[Effect]] = (), linear: bool = False) -> list[type[Effect]]:
    """The effects that ship and that the vehicle has words for, and a user's own; without those that have no
    eigenvalues if `linear`."""
    return [
        e
        for e in applicable_effects(vehicle, [*VEHICLE_EFFECTS, *own])
        if not (linear and (e.family in (*NOT_LINEAR, *OF_INPUTS) or not getattr(e, "linear", True)))
    ]


def vehicle_runs_experiment(
    vehicle: Component, free: Sequence[str] = (), predicted: bool = False, criteria: Criteria = Criteria()
) -> VehicleOverSpeedExperiment:
    """The vehicle with what is free in it: entries of given matrices may be any number, known to a share of their terms
    unless they are in `free`.

    What a roll torque does stays as given, as nobody applies one, unless the vehicle is `predicted`:
    there disturbances do.
    """
    if not isinstance(vehicle, GivenMatrices):
        return VehicleOverSpeedExperiment(vehicle, "", "speed", uncertain(vehicle, free, prefix=""), exact_delays=True)
    unrestricted = tuple(
        n
        for n, value in vehicle.values.items()
        if (value != 0 and (predicted or not n.endswith("roll_torque"))) or n in free
    )
    known = {
        n: (vehicle.values[n], error)
        for n, error in _entry_errors(vehicle, criteria).items()
        if n in unrestricted and n not in free and ALL not in free
    }
    return VehicleOverSpeedExperiment(
        vehicle, "", "speed", unrestricted=unrestricted, measured_effects=known, exact_delays=True
    )


def _entry_errors(vehicle: GivenMatrices, criteria: Criteria) -> dict[str, float]:
    """To how much the entries of given matrices are known: to `given_matrix_error` of the terms of
    which each is the sum.

        A_ij = sum_k B_ik (M A)_kj,     B_ij = sum_kl B_ik M_kl B_lj,     M = B^-1

    An entry may be a small difference of large terms, each with the error of a moment or an inertia.
    """
    of = vehicle.values
    B = np.array([[of[f"{i}_by_{j}_torque"] for j in COORDINATES] for i in COORDINATES])
    M = np.linalg.inv(B)
    errors = {
        f"{i}_by_{j}_torque": np.linalg.norm(B[a][:, None] * M * B[:, b])
        for a, i in enumerate(COORDINATES)
        for b, j in enumerate(COORDINATES)
    }
    for column in (f"{j}_{power}" for j in STATES for power in range(3)):
        A = np.array([of[f"{i}_by_{column}"] for i in COORDINATES])
        errors |= {f"{i}_by_{column}": np.linalg.norm(B[a] * (M @ A)) for a, i in enumerate(COORDINATES)}
    return {n: criteria.given_matrix_error * float(x) for n, x in errors.items()}


def with_names(run: MeasuredEigenvalues, experiment: VehicleOverSpeedExperiment) -> MeasuredEigenvalues:
    """The measured eigenvalues with the eigenvectors that their modes have in the base; a name that the base does
    not have is ignored."""
    mode = tuple(m.strip().lower().replace("-", "_").replace(" ", "_") for m in run.mode)
    at, place = np.unique(run.over, return_inverse=True)
    found = modes(over_speed(experiment.component), at)  # type: ignore[arg-type]
    nominal = np.array(
        [found[m].eigenvalue[k] if m in MODES else np.nan for m, k in zip(mode, place, strict=True)], complex
    )
    return with_mode_shapes(replace(run, mode=mode), experiment, nominal)
