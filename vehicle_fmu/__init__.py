"""The motorcycles, the bicycle and the steering dampers, all with the handlebar port.

    from vehicle_fmu import dampers, motorcycles
    motorcycles.load("sharp_1971"), dampers.load("high_2011")
"""

from pathlib import Path

from fmus.library import Library
from vehicle_fmu.bicycle import Bicycle
from vehicle_fmu.dampers import InerterCompensator, LinearDamper, ProgressiveDamper
from vehicle_fmu.given_matrices import GivenMatrices
from vehicle_fmu.mode_names import MODES
from vehicle_fmu.motorcycle import Motorcycle
from vehicle_fmu.named_modes import Mode, Modes, modes
from vehicle_fmu.ridden import over_speed, ridden

VEHICLES = {"Motorcycle": Motorcycle, "Bicycle": Bicycle, "GivenMatrices": GivenMatrices}
DAMPERS = {c.__name__: c for c in (LinearDamper, ProgressiveDamper, InerterCompensator)}
motorcycles = Library("motorcycle", Path(__file__).parent / "motorcycles", VEHICLES)
dampers = Library("damper", Path(__file__).parent / "dampers", DAMPERS)

__all__ = ["DAMPERS", "MODES", "VEHICLES", "Bicycle", "GivenMatrices", "InerterCompensator", "LinearDamper", "Mode", "Modes", "Motorcycle",
           "ProgressiveDamper", "dampers", "modes", "motorcycles", "over_speed", "ridden"]  # fmt: skip
