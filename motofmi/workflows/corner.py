"""Steady turning of a vehicle with devices that are given by name, and the start of its FMU in it."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fmus.declaration.component import Component, in_bounds
from fmus.interfaces.held_posture import HeldPosture
from fmus.support.errors import InputError
from motofmi.workflows.components import ComponentLike
from motofmi.workflows.components import vehicle as vehicle_of
from motofmi.workflows.modes import Devices
from motofmi.workflows.parts import Part, parts
from motofmi.workflows.ssp_archive import started
from vehicle_fmu.large_motion.corner_modes import check_devices, held
from vehicle_fmu.large_motion.equations import LargeMotion
from vehicle_fmu.large_motion.in_space import in_large_motion, start_of
from vehicle_fmu.large_motion.steady_turning import Equilibrium, SteadyTurning
from vehicle_fmu.large_motion.touring_tree import check_large_motion
from vehicle_fmu.ridden import by_name

LARGEST_LEAN = 80.0  # deg
TOLERANCE = 1e-7  # of the FMU's inner steps: of 1 ms they are exact to 1e-12 rad, and no shorter ones are needed


@dataclass(frozen=True)
class Corner:
    """A vehicle with devices in steady turning at a speed; `given` is the vehicle without changed parameters."""

    given: Component
    whole: Component
    devices: list[Component]
    turning: SteadyTurning

    def start(self, lean: float) -> "CornerStart":
        """The start at a lean angle [deg]. Raises InputError where there is no equilibrium or the vehicle has locked
        freedoms.
        """
        shipped, changed = in_large_motion(self.given), in_large_motion(self.whole)
        motion, equilibrium = self.turning.motion, self._equilibrium(lean)
        values = start_of(motion, equilibrium)
        states = {name: values.pop(name) for name in shipped.states}
        values |= {name: value for name, value in changed.values.items() if value != shipped.values[name]}
        values["relative_tolerance"] = TOLERANCE
        moving = motion.outputs(motion.at(equilibrium.x, equilibrium.u))
        posture = {f"held_{name}": float(moving[name]) for name in ("steer_angle", "frame_rate")}
        devices = [device.with_effects(HeldPosture()) for device in self.devices]
        each = {"vehicle": values, **dict.fromkeys(by_name(devices), posture)}
        return CornerStart(shipped, list(devices), states, each)

    def component(self, lean: float) -> Component:
        """The vehicle alone, in large motion, whose start values are those of `start`."""
        return started(in_large_motion(self.whole), start_of(self.turning.motion, self._equilibrium(lean)))

    def _equilibrium(self, lean: float) -> Equilibrium:
        return self.turning.at(float(np.radians(checked("lean angles", "deg", lean, LARGEST_LEAN)[0])))


@dataclass(frozen=True)
class CornerStart:
    """A vehicle in large motion and its devices, as parts of a co-simulation: the vehicle's states, and the parameters
    and constant inputs of each part by name.
    """

    vehicle: Component
    devices: list[Part]
    states: dict[str, float]
    values: dict[str, dict[str, float]]


def in_corner(
    vehicle: ComponentLike | None, device: Devices, settings: Mapping[str, float] | None, speed: float
) -> Corner:
    """Vehicle and devices with parameters and numbers of its supplement set, and the equilibria at a speed [m/s].

    Raises InputError for a vehicle without equations in large motion, a device that acts at more than the handlebar,
    and an FMU.
    """
    if vehicle is None:
        raise InputError("no vehicle is given: give its name, such as tum_2020")
    given, changed = vehicle_of(vehicle), dict(settings or {})
    supplement = {name: float(changed.pop(name)) for name in list(changed) if name in given.supplement}
    found = parts(given, device, changed)
    components = [each for each in (found[0], *found[1]) if isinstance(each, Component)]
    if len(components) <= len(found[1]):
        raise InputError("steady turning takes components, not FMUs: give the name or the value file of the device")
    whole, *devices = components
    whole.supplement.update(supplement)
    check_large_motion(whole)
    check_devices(devices)
    at = in_bounds(speed, whole.table["speed"], whole.name)
    return Corner(given, whole, devices, SteadyTurning(LargeMotion(held(whole, devices)), at))


def checked(what: str, unit: str, given: ArrayLike, largest: float) -> np.ndarray:
    """One value or several as an array (n,). Raises InputError for other shapes and for values beyond the largest."""
    values = np.atleast_1d(np.asarray(given, float))
    if not (np.isfinite(values).all() and (np.abs(values) <= largest).all() and values.ndim == 1 and len(values)):
        shown = np.array2string(values, threshold=6)
        raise InputError(f"{what} must be from -{largest:g} to {largest:g} [{unit}], not {shown}")
    return values
