"""The rig of the steer test for the gap workflow: handlebar and passive rider, the angle imposed, the torque measured."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fmus.effects.channel
import rider_fmu.effects
from fmus import Effect, System
from fmus.effects import effects_in, load_folder
from fmus.effects.library import declared_by
from identification.gap.test_stand import Free, TestStand
from rider_fmu import Handlebar, riders

RIDER = ("torso_inertia", "arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping")
RUN_TO_RUN = 0.04  # by which a rider changes from one run to the next, relative
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
    return TestStand(system, "bar.steer_angle", "bar.servo_torque", free, COLUMNS)


def rig_effects(folder: str | Path | None = None) -> list[type[Effect]]:
    """The effects of riders and of measuring channels that ship, and a user's own from a folder."""
    return effects_in(rider_fmu.effects) + declared_by(fmus.effects.channel) + (load_folder(folder) if folder else [])
