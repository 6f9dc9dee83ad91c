"""The rig of the steer test for the gap workflow: handlebar and passive rider, the angle imposed, the torque measured."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import fmus.effects.channel
import rider_fmu.effects
from fmus import Effect, System
from fmus.effects import effects_in, load_folder
from fmus.effects.library import declared_by
from identification.gap.data.runs import Run
from identification.gap.stands.test_stand import Free, Sensor, TestStand
from rider_fmu import Handlebar, riders

RIDER = ("torso_inertia", "arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping")
RUN_TO_RUN = 0.04  # by which a rider changes from one run to the next, relative
DAMPING, STIFFNESS = "device.steer_damping.damping", "device.steer_stiffness.stiffness"  # of the bar itself
GYRO = "torso_rate"  # of a gyro on the rider's back
GYRO_NOISE = 0.01  # rad/s, where rig.json says nothing
COLUMNS = {"imposed": "steer_angle", "measured": "steer_torque", "command": "steer_angle_command"}


def rig_test(rig: Mapping[str, Any], rider: str = "mean_2011") -> TestStand:
    """The test as `rig.json` describes it, starting from a published rider's values."""
    inertia = rig.get("handlebar_inertia", {})
    known = inertia.get("value")
    error = inertia.get("standard_error") or (0.01 * known if known else 0.0)
    device = riders.load(rider)
    bar = Handlebar("bar", steer_inertia=known or 0.125)
    system = System("rig", {"bar": bar, "device": device}, bindings={"bar.added_steer_inertia": "device.port_inertia"})
    free = (Free("bar.steer_inertia", 0.0, known, error), *(Free(f"device.{name}", RUN_TO_RUN) for name in RIDER))
    gyro = Sensor("device.torso_rate", rig.get("noise", {}).get(GYRO, GYRO_NOISE))
    return TestStand(system, "bar.steer_angle", "bar.servo_torque", free, COLUMNS, further={GYRO: gyro})


def bare_bar(runs: Sequence[Run]) -> tuple[np.ndarray, np.ndarray]:
    """Inertia, damping and stiffness of the bar itself and their errors, (3,) each, from sweeps of it, hands off.

        T = I a + c s + k delta, by weighted least squares on the harmonics

    Where more is in the bar than that (friction), the errors grow by the root of the reduced chi-square.
    """
    columns, data = [], []
    for run in runs:
        angle, rate, acceleration = run.moved(run.recording.time)
        columns.append(run.reduction.reduce(np.column_stack([acceleration, rate, angle])) / run.effort.deviation[:, None])
        data.append(run.effort.data / run.effort.deviation)
    matrix, target = np.concatenate(columns), np.concatenate(data)
    found, left = np.linalg.lstsq(matrix, target, rcond=None)[:2]
    worse = max(float(left[0]) / (len(target) - 3), 1.0)
    return found, np.sqrt(worse * np.diag(np.linalg.inv(matrix.T @ matrix)))


def with_bare_bar(stand: TestStand, runs: Sequence[Run]) -> TestStand:
    """The test with what sweeps of the bare handlebar, hands off, say of the bar itself."""
    (inertia, damping, stiffness), errors = bare_bar(runs)
    bar = replace(stand.free[0], known=float(inertia), standard_error=float(errors[0]))
    measured = {DAMPING: (float(damping), float(errors[1])), STIFFNESS: (float(stiffness), float(errors[2]))}
    return replace(stand, free=(bar, *stand.free[1:]), measured_effects=measured)


def rig_effects(folder: str | Path | None = None) -> list[type[Effect]]:
    """The effects of riders and of measuring channels that ship, and a user's own from a folder."""
    return effects_in(rider_fmu.effects) + declared_by(fmus.effects.channel) + (load_folder(folder) if folder else [])
