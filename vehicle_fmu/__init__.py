"""Motorcycles, a bicycle and steering dampers, with the handlebar port, and the modes of a vehicle over its speed.

    from vehicle_fmu import dampers, motorcycles
    motorcycles.load("sharp_1971"), dampers.load("high_2011")

Every component that a file in `components/` defines is registered: devices of the handlebar port in DAMPERS, all
others in VEHICLES. `motorcycles` and `dampers` hold the value files.
"""

from pathlib import Path

from fmus.composition.component_folder import components_in
from fmus.composition.value_files import Library
from fmus.interfaces.handlebar import HandlebarDevice
from vehicle_fmu.components.bicycle import Bicycle
from vehicle_fmu.components.dampers import InerterCompensator, LinearDamper, ProgressiveDamper
from vehicle_fmu.components.given_matrices import GivenMatrices
from vehicle_fmu.components.motorcycle import Motorcycle
from vehicle_fmu.mode_names import MODES
from vehicle_fmu.named_modes import Mode, Modes, modes
from vehicle_fmu.ridden import over_speed, ridden

COMPONENTS = components_in("vehicle_fmu.components")
DAMPERS = {name: c for name, c in COMPONENTS.items() if issubclass(c, HandlebarDevice)}
VEHICLES = {name: c for name, c in COMPONENTS.items() if name not in DAMPERS}
motorcycles = Library("motorcycle", Path(__file__).parent / "motorcycles", VEHICLES)
dampers = Library("damper", Path(__file__).parent / "dampers", DAMPERS)

__all__ = ["COMPONENTS", "DAMPERS", "MODES", "VEHICLES", "Bicycle", "GivenMatrices", "InerterCompensator",
           "LinearDamper", "Mode", "Modes", "Motorcycle", "ProgressiveDamper", "dampers", "modes",
           "motorcycles", "over_speed", "ridden"]  # fmt: skip
