"""The component of a motorcycle in large motion from its value file, and its start in steady turning."""

from types import SimpleNamespace

from fmus.declaration.component import Component
from fmus.support.errors import InputError
from vehicle_fmu.components.motorcycle_in_space import TouringMotorcycleInSpace
from vehicle_fmu.components.touring_motorcycle import FLEXIBLE
from vehicle_fmu.large_motion.applied_forces import INPUTS
from vehicle_fmu.large_motion.equations import ENDS, LargeMotion
from vehicle_fmu.large_motion.steady_turning import Equilibrium
from vehicle_fmu.large_motion.touring_tree import PLANE, check_large_motion

RATES = {"along": "forward_speed", "lateral": "lateral_velocity", "vertical": "vertical_velocity"}
POSITIONS = {
    "vertical": "vertical_position",
    "roll": "roll_angle",
    "pitch": "pitch_angle",
    "steer": "steer_angle",
    "yaw": "heading",
    "along": "path_x",
    "lateral": "path_y",
}


def in_large_motion(motorcycle: Component) -> TouringMotorcycleInSpace:
    """The motorcycle with its parameters and its supplement as parameters of the equations in large motion.

    Raises InputError for a vehicle that has no such equations, or lacks values for them, or has a locked freedom: the
    component has all freedoms free.
    """
    check_large_motion(motorcycle)
    given = {**motorcycle.values, **motorcycle.supplement}
    if locked := [name for name in (*FLEXIBLE, *PLANE) if given[name] != 1.0]:
        raise InputError(
            f"{motorcycle.name}: {locked[0]} = {given[locked[0]]:g}, but the component in large motion has all "
            f"freedoms free; leave {locked[0]} = 1, and raise its stiffness if it has one"
        )
    values = {name: value for name, value in given.items() if name in TouringMotorcycleInSpace.declared}
    found = TouringMotorcycleInSpace(f"{motorcycle.name}_in_space", motorcycle.source, (), **values)
    found.assumed = {name: reason for name, reason in motorcycle.assumed.items() if name in found.values}
    return found


def states_of(motion: LargeMotion, found: SimpleNamespace) -> dict[str, float]:
    """The states of the component by name at what `LargeMotion.posed` finds, the path and the heading from 0."""
    states = {}
    for name, k in motion.place.items():
        states[RATES.get(name, f"{name}_rate")] = float(found.w[k])
        if not name.endswith("_spin"):
            states[POSITIONS.get(name, f"{name}_position")] = float(found.q[k])
    return states | {f"{end}_relaxed_slip": float(found.relaxed[end]) for end in ENDS}


def start_of(motion: LargeMotion, equilibrium: Equilibrium) -> dict[str, float]:
    """The states and the inputs of the component by name with which it keeps an equilibrium without acceleration."""
    return states_of(motion, equilibrium.found) | dict(zip(INPUTS, equilibrium.u.tolist(), strict=True))
