"""Riders with the ports of motorcycles, and the rigs on which riders were measured.

    from rider_fmu import riders
    riders.load("mean_2011")

COMPONENTS holds every component that a file in `components/` or `rigs/` defines; `riders` holds the value files.
"""

from pathlib import Path

from fmus.composition.component_folder import components_in
from fmus.composition.value_files import Library
from rider_fmu.components.full_rider import FullRider, FullRiderOnRig
from rider_fmu.components.passive_rider import PassiveRider
from rider_fmu.components.rider_in_roll import RiderInRoll
from rider_fmu.rigs.handlebar import Handlebar
from rider_fmu.rigs.roll_rig import RollRig
from rider_fmu.rigs.steer_rig import SteerRig

COMPONENTS = components_in("rider_fmu.components", "rider_fmu.rigs")
riders = Library("rider", Path(__file__).parent / "riders", COMPONENTS)

__all__ = ["COMPONENTS", "FullRider", "FullRiderOnRig", "Handlebar", "PassiveRider", "RiderInRoll", "RollRig",
           "SteerRig", "riders"]  # fmt: skip
