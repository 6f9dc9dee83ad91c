"""The vehicle as an experiment of the gap workflow: prior knowledge of its parameters, and the effects it may lack."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fmus.declaration.component import Component
from fmus.effects import Effect
from fmus.effects.library import applicable_effects, obstacle
from fmus.support.errors import unknown
from motofmi.gap.criteria import Criteria
from motofmi.gap.experiments.experiment import FreeParameter
from motofmi.gap.experiments.vehicle_over_speed import VehicleOverSpeedExperiment
from motofmi.gap.models.eigenvalue_model import with_mode_shapes
from motofmi.gap.preprocessing.eigenvalues import MeasuredEigenvalues
from motofmi.workflows.components import VEHICLE_EFFECTS
from vehicle_fmu import MODES, GivenMatrices, modes, over_speed, ridden
from vehicle_fmu.components.given_matrices import COORDINATES, STATES

# Relative standard error of a vehicle's parameters by unit, if its file gives none: masses and lengths are weighed and
# measured; inertias, tyre stiffness and damping come from pendulum and tyre tests.
RELATIVE_ERROR = {"kg": 0.01, "m": 0.01, "rad": 0.01, "kg.m2": 0.05, "N/rad": 0.05, "N.m.s/rad": 0.05}
RELAXATION_LENGTH_ERROR = 0.05  # relative standard error of a relaxation length, which comes from a tyre test
ALL = "all"  # in `free`: no parameter of the base has prior knowledge
EXACT = ("gravity",)  # parameters that are not fitted
NONLINEAR = ("coulomb_friction",)  # has no eigenvalues; it changes measured ones like a damper
OF_INPUTS = ("motor_gain", "channel_delay")  # effects that do not change eigenvalues
# Effects that are not distinguishable from the hands on a handlebar whose torque is not recorded
LIKE_HANDS = (
    "coulomb_friction",
    "steer_stiffness",
    "steer_damping",
    "added_inertia",
    "motor_gain",
    "passive_rider",
)


def free_parameters_of(
    vehicle: Component, free: Sequence[str] = (), prefix: str = "vehicle."
) -> tuple[FreeParameter, ...]:
    """The fitted parameters of the base: those in `free` without prior knowledge, every other positive one with it.

    The prior is the value with the standard_error of the vehicle's file, else with RELATIVE_ERROR by unit. Raises
    InputError for an unknown name in `free`.
    """
    rows = vehicle.rows("parameter")
    for name in free:
        if name not in rows:
            raise unknown(f"parameter of {vehicle.name}", name, rows)
    found = []
    for name, row in rows.items():
        value = vehicle.values[name]
        relative = RELAXATION_LENGTH_ERROR if "relaxation" in name else RELATIVE_ERROR.get(row.unit, 0.0)
        error = vehicle.standard_error.get(name, relative * value)
        if name in free:
            found.append(FreeParameter(prefix + name))
        elif name not in EXACT and value > 0 and error > 0:
            found.append(FreeParameter(prefix + name, 0.0, value, error))
    return tuple(found)


def vehicle_experiment(
    vehicle: Component, device: Component | None = None, free: Sequence[str] = ()
) -> VehicleOverSpeedExperiment:
    """The vehicle over its speed, alone or with a device at the handlebar. Raises InputError for unknown names in
    free."""
    return VehicleOverSpeedExperiment(ridden(vehicle, device), "vehicle", "vehicle.speed",
                                      free_parameters_of(vehicle, free))


def vehicle_effects(vehicle: Component, own: Sequence[type[Effect]] = (), linear: bool = False) -> list[type[Effect]]:
    """The shipped effects that are applicable to the vehicle, and a user's own.

    With `linear`, effects are left out that do not change eigenvalues or have none.
    """
    return [
        e
        for e in applicable_effects(vehicle, [*VEHICLE_EFFECTS, *own])
        if not (linear and (e.family in (*NONLINEAR, *OF_INPUTS) or not getattr(e, "linear", True)))
    ]


def not_applicable(vehicle: Component, own: Sequence[type[Effect]]) -> list[str]:
    """A sentence on each of a user's own effects that does not apply to the vehicle. Raises InputError as `obstacle`
    does."""
    reasons = {effect: obstacle(vehicle, effect) for effect in own}
    return [f"{e.family}.{e.form} is left out: {reason}." for e, reason in reasons.items() if reason]


def vehicle_runs_experiment(
    vehicle: Component, free: Sequence[str] = (), predicted: bool = False, criteria: Criteria = Criteria()
) -> VehicleOverSpeedExperiment:
    """The vehicle with its fitted parameters, for recorded runs.

    Entries of given matrices may have either sign; unless they are in `free`, they have a prior (see `_entry_errors`).
    The columns of the roll torque are fitted only if the vehicle is `predicted`, because only disturbances exert one.
    """
    if not isinstance(vehicle, GivenMatrices):
        return VehicleOverSpeedExperiment(vehicle, "", "speed", free_parameters_of(vehicle, free, prefix=""),
                                          exact_delays=True)
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
    """Standard errors of the entries of given matrices: `given_matrix_error` times the norm of the terms that each
    sums.

        A_ij = sum_k B_ik (M A)_kj,     B_ij = sum_kl B_ik M_kl B_lj,     M = B^-1

    An entry may be a small difference of large terms, each with the error of a moment or an inertia. Units as the
    entry.
    """
    values = vehicle.values
    B = np.array([[values[f"{i}_by_{j}_torque"] for j in COORDINATES] for i in COORDINATES])
    M = np.linalg.inv(B)
    errors = {
        f"{i}_by_{j}_torque": np.linalg.norm(B[a][:, None] * M * B[:, b])
        for a, i in enumerate(COORDINATES)
        for b, j in enumerate(COORDINATES)
    }
    for column in (f"{j}_{power}" for j in STATES for power in range(3)):
        A = np.array([values[f"{i}_by_{column}"] for i in COORDINATES])
        errors |= {f"{i}_by_{column}": np.linalg.norm(B[a] * (M @ A)) for a, i in enumerate(COORDINATES)}
    return {n: criteria.given_matrix_error * float(x) for n, x in errors.items()}


def with_mode_names(run: MeasuredEigenvalues, experiment: VehicleOverSpeedExperiment) -> MeasuredEigenvalues:
    """The measured eigenvalues with the eigenvectors that their modes have in the base.

    A mode name that the base does not have is ignored.
    """
    mode = tuple(m.strip().lower().replace("-", "_").replace(" ", "_") for m in run.mode)
    at, place = np.unique(run.over, return_inverse=True)
    found = modes(over_speed(experiment.component), at)  # type: ignore[arg-type]
    nominal = np.array(
        [found[m].eigenvalue[k] if m in MODES else np.nan for m, k in zip(mode, place, strict=True)], complex
    )
    return with_mode_shapes(replace(run, mode=mode), experiment, nominal)
