"""The rig of the steer test as an experiment of the gap workflow: handlebar and passive rider, angle imposed, torque
measured."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import fmus.effects.measuring_channel
import rider_fmu.effects
from fmus import Effect, System
from fmus.effects import effects_in
from fmus.effects.library import declared_by
from motofmi.gap.experiments.experiment import FreeParameter, ImposedMotionExperiment, Sensor
from motofmi.gap.preprocessing.steer_test_run import SteerTestRun
from motofmi.recordings.channels import STEER_ANGLE, STEER_ANGLE_COMMAND, STEER_TORQUE, TORSO_RATE
from rider_fmu import Handlebar, riders
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA

RIDER_PARAMETERS = ("torso_inertia", "arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping")
RUN_TO_RUN = 0.04  # relative standard deviation of a rider's parameters between runs
DAMPING, STIFFNESS = "device.steer_damping.damping", "device.steer_stiffness.stiffness"  # of the handlebar itself
GYRO_NOISE = 0.01  # rad/s; standard deviation if rig.json gives none
COLUMNS = {"imposed": STEER_ANGLE, "measured": STEER_TORQUE, "command": STEER_ANGLE_COMMAND}


def rig_experiment(rig: Mapping[str, Any], rider: str = "mean_2011") -> ImposedMotionExperiment:
    """The experiment that `rig.json` describes; the fit starts from the values of a published rider.

    Raises InputError for an unknown rider.
    """
    inertia = rig.get("handlebar_inertia", {})
    known = inertia.get("value")
    error = inertia.get("standard_error") or (0.01 * known if known else 0.0)
    device = riders.load(rider)
    bar = Handlebar("bar", steer_inertia=known or HANDLEBAR_INERTIA)
    system = System("rig", {"bar": bar, "device": device}, bindings={"bar.added_steer_inertia": "device.port_inertia"})
    free = (
        FreeParameter("bar.steer_inertia", 0.0, known, error),
        *(FreeParameter(f"device.{name}", RUN_TO_RUN) for name in RIDER_PARAMETERS),
    )
    gyro = Sensor("device.torso_rate", rig.get("noise", {}).get(TORSO_RATE, GYRO_NOISE))
    return ImposedMotionExperiment(
        system, "bar.steer_angle", "bar.servo_torque", free, COLUMNS, further={TORSO_RATE: gyro}
    )


def bare_bar(runs: Sequence[SteerTestRun]) -> tuple[np.ndarray, np.ndarray]:
    """Inertia [kg.m2], damping [N.m.s/rad] and stiffness [N.m/rad] of the bare handlebar, and their errors, (3,) each.

        T = I delta'' + c delta' + k delta, by weighted least squares on the harmonics of sweeps without a rider

    A reduced chi-square above 1 (friction, for example) scales the errors by its square root.
    """
    columns, data = [], []
    for run in runs:
        angle, rate, acceleration = run.motion_at(run.recording.time)
        columns.append(
            run.reduction.reduce(np.column_stack([acceleration, rate, angle])) / run.effort.deviation[:, None]
        )
        data.append(run.effort.data / run.effort.deviation)
    matrix, target = np.concatenate(columns), np.concatenate(data)
    found, left = np.linalg.lstsq(matrix, target, rcond=None)[:2]
    excess = max(float(left[0]) / (len(target) - 3), 1.0)
    return found, np.sqrt(excess * np.diag(np.linalg.inv(matrix.T @ matrix)))


def with_bare_bar(experiment: ImposedMotionExperiment, runs: Sequence[SteerTestRun]) -> ImposedMotionExperiment:
    """The experiment with inertia, damping and stiffness of the handlebar known from sweeps without a rider."""
    (inertia, damping, stiffness), errors = bare_bar(runs)
    bar = replace(experiment.free[0], known=float(inertia), standard_error=float(errors[0]))
    measured = {DAMPING: (float(damping), float(errors[1])), STIFFNESS: (float(stiffness), float(errors[2]))}
    return replace(experiment, free=(bar, *experiment.free[1:]), measured_effects=measured)


def rig_effects(own: Sequence[type[Effect]] = ()) -> list[type[Effect]]:
    """The shipped effects of riders and of measuring channels, and a user's own."""
    return [*effects_in(rider_fmu.effects), *declared_by(fmus.effects.measuring_channel), *own]
