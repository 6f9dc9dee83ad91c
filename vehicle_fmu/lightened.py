"""A motorcycle without a part of its rigid rider, for a rider who moves on it and brings that part himself.

A body of mass m and roll inertia J (about its own mass centre) at height z above the ground, above the rear
frame's mass centre, is taken out of the rear frame:

    M' = M_r - m,   h' = (M_r h - m z) / M',   I_rx' = I_rx + M_r h^2 - M' h'^2 - J - m z^2
"""

from fmus.component import Component
from fmus.errors import InputError


def lightened(motorcycle: Component, mass: float, height: float, roll_inertia: float) -> Component:
    """The motorcycle without a body of that mass [kg], height [m] and roll inertia [kg.m2].

    Raises InputError when the rest of the rear frame would have no mass, height or roll inertia left.
    """
    p = motorcycle.values
    rest = p["rear_mass"] - mass
    moment = p["rear_mass"] * p["rear_mass_height"] - mass * height
    if rest <= 0 or moment < 0:
        raise InputError(f"{motorcycle.name}: its rear frame of {p['rear_mass']:g} kg at {p['rear_mass_height']:g} m does not hold {mass:g} kg at {height:g} m")
    left = p["rear_roll_inertia"] + p["rear_mass"] * p["rear_mass_height"] ** 2 - moment**2 / rest - roll_inertia - mass * height**2
    if left <= 0:
        raise InputError(f"{motorcycle.name}: without {mass:g} kg at {height:g} m its rear_roll_inertia would be {left:g} kg.m2; lower saddle or rider")
    return motorcycle.with_values(rear_mass=rest, rear_mass_height=moment / rest, rear_roll_inertia=left)
