"""The riders: passive riders with the handlebar port, and the bar of the rig on which they were measured.

    from rider_fmu import riders
    riders.load("mean_2011")
"""

from pathlib import Path

from fmus.library import Library
from rider_fmu.full_rider import FullRider, FullRiderOnRig
from rider_fmu.handlebar import Handlebar
from rider_fmu.passive_rider import PassiveRider
from rider_fmu.rider_in_roll import RiderInRoll
from rider_fmu.rig import SteerRig
from rider_fmu.roll_rig import RollRig

COMPONENTS = {c.__name__: c for c in (PassiveRider, FullRider, FullRiderOnRig, RiderInRoll, Handlebar, SteerRig, RollRig)}
riders = Library("rider", Path(__file__).parent / "riders", COMPONENTS)

__all__ = ["COMPONENTS", "FullRider", "FullRiderOnRig", "Handlebar", "PassiveRider", "RiderInRoll", "RollRig", "SteerRig",
           "riders"]  # fmt: skip
