"""A motorcycle without a part of its rigid rider, for a rider who moves on it and brings that part himself.

A body of mass m and roll inertia J (about its own mass centre) at height z above the ground, above the rear
frame's mass centre, is taken out of the rear frame:

    M' = M_r - m,   h' = (M_r h - m z) / M',   I_rx' = I_rx + M_r h^2 - M' h'^2 - J - m z^2
"""

from collections.abc import Mapping

from fmus.component import Component
from fmus.errors import InputError

BODY = ("rider_mass", "rider_height", "rider_roll_inertia")  # what a rider who leans says of himself
REAR_FRAME = ("rear_mass", "rear_mass_height", "rear_roll_inertia")


def lightened(motorcycle: Component, mass: float, height: float, roll_inertia: float) -> Component:
    """The motorcycle without a body of that mass [kg], height [m] and roll inertia [kg.m2].

    Raises InputError when the rest of the rear frame would have no mass, height or roll inertia left, and for a vehicle
    that has no such rear frame.
    """
    return motorcycle.with_values(**rest_of(motorcycle.name, motorcycle.values, mass, height, roll_inertia))


def rest_of(name: str, values: Mapping[str, float], mass: float, height: float, roll_inertia: float) -> dict[str, float]:
    """The values of REAR_FRAME that are left of a vehicle's of that name."""
    if not set(REAR_FRAME) <= values.keys():
        raise InputError(f"{name} has not the parameters {', '.join(REAR_FRAME)} from which a rider who leans could be taken; use a motorcycle")
    whole, centre, inertia = (values[n] for n in REAR_FRAME)
    rest = whole - mass
    moment = whole * centre - mass * height
    if rest <= 0 or moment < 0:
        raise InputError(f"{name}: its rear frame of {whole:g} kg at {centre:g} m does not hold {mass:g} kg at {height:g} m")
    left = inertia + whole * centre**2 - moment**2 / rest - roll_inertia - mass * height**2
    if left <= 0:
        raise InputError(f"{name}: without {mass:g} kg at {height:g} m its rear_roll_inertia would be {left:g} kg.m2; lower saddle or rider")
    return dict(zip(REAR_FRAME, (rest, moment / rest, left), strict=True))
