"""The riders: passive riders with the handlebar port, and the bar of the rig on which they were measured.

    from rider_fmu import riders
    riders.load("mean_2011")
"""

from pathlib import Path

from fmus.library import Library
from rider_fmu.handlebar import Handlebar
from rider_fmu.passive_rider import PassiveRider
from rider_fmu.rig import SteerRig

COMPONENTS = {"PassiveRider": PassiveRider, "Handlebar": Handlebar, "SteerRig": SteerRig}
riders = Library("rider", Path(__file__).parent / "riders", COMPONENTS)

__all__ = ["COMPONENTS", "Handlebar", "PassiveRider", "SteerRig", "riders"]
