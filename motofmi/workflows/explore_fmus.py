"""FMUs of other tools in an explore page: linearised here, because the page runs no code that does not ship with it.

An FMU at a vehicle's ports does not depend on the speed, so that one Jacobian d(x', y)/d(x, u) holds for all speeds.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fmus.cosimulation.network import agree
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.interfaces.handlebar import MOTION, TORQUES
from fmus.interfaces.roll import ROLL
from fmus.support.errors import InputError
from motofmi.workflows.parts import PORTS, role_of
from vehicle_fmu.rider_mass_removed import RIDER_BODY

PORT_UNITS = {name: unit for name, (unit, *_) in {**MOTION, **TORQUES, **ROLL}.items()}
CALCULATED = ("port_inertia", *RIDER_BODY)  # values of a device that change the vehicle


@dataclass(frozen=True)
class LinearisedFmu:
    """A device of another tool: its name, where it comes from, and its module for the page without WebAssembly."""

    name: str
    source: str
    module: Mapping[str, Any]


def linearised_fmu(path: str | Path) -> LinearisedFmu:
    """The FMU of a device, linearised at its start values.

    Raises InputError for an archive without a port, with that of a vehicle or in other units, and for one that cannot
    be run here.
    """
    role = role_of(path)
    if role not in PORTS:
        raise InputError(f"{path} has the port of a vehicle: explore takes FMUs of devices, with --device; "
                         "motofmi modes --fmu takes this one")  # fmt: skip
    name = Path(path).name
    with FmuSubsystem(path, "device") as fmu:
        for variable, unit in PORT_UNITS.items():
            if variable in fmu.variables and not agree(fmu.unit_of(variable), unit):
                raise InputError(f"{path}: {variable} has the unit [{fmu.unit_of(variable)}], expected [{unit}]")
        space = fmu.linearised()
        values = {n: fmu.get(n) for n in CALCULATED if n in fmu.variables}
    jacobian = np.block([[space.A, space.B], [space.C, space.D]])
    return LinearisedFmu(name, str(path), {
        "title": name, "states": list(space.states), "inputs": list(space.inputs), "outputs": list(space.outputs),
        "references": values, "parameters": {}, "jacobian": jacobian.tolist(),
    })  # fmt: skip
