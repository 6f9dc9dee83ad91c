"""A motorcycle from whose rear frame the mass of a rider is removed, for a rider model that has this mass itself.

A body of mass m and roll inertia J (about its own mass centre) at height z above the ground, above the rear
frame's mass centre, is removed from the rear frame:

    M' = M_r - m,   h' = (M_r h - m z) / M',   I_rx' = I_rx + M_r h^2 - M' h'^2 - J - m z^2
"""

from collections.abc import Mapping

from fmus.declaration.component import Component
from fmus.support.errors import InputError

RIDER_BODY = ("rider_mass", "rider_height", "rider_roll_inertia")  # calculated parameters of a leaning rider
REAR_FRAME = ("rear_mass", "rear_mass_height", "rear_roll_inertia")


def without_rider_mass(motorcycle: Component, mass: float, height: float, roll_inertia: float) -> Component:
    """The motorcycle without a body of that mass [kg], height [m] and roll inertia [kg.m2] in its rear frame.

    Raises InputError when the mass, the height or the roll inertia of the rest would not be positive, and for a vehicle
    without such a rear frame.
    """
    return motorcycle.with_values(**rear_frame_without(motorcycle.name, motorcycle.values, mass, height, roll_inertia))


def rear_frame_without(
    name: str, values: Mapping[str, float], mass: float, height: float, roll_inertia: float
) -> dict[str, float]:
    """The values of REAR_FRAME after the removal, from all values of the vehicle of that name."""
    if not set(REAR_FRAME) <= values.keys():
        raise InputError(
            f"{name} lacks the parameters {', '.join(REAR_FRAME)}, from which the mass of a leaning rider is removed; "
            "use a motorcycle with a rigid rider, such as sharp_1971"
        )
    whole, centre, inertia = (values[n] for n in REAR_FRAME)
    rest = whole - mass
    moment = whole * centre - mass * height
    if rest <= 0 or moment < 0:
        raise InputError(
            f"{name}: its rear frame of {whole:g} kg at {centre:g} m does not contain {mass:g} kg at {height:g} m"
        )
    left = inertia + whole * centre**2 - moment**2 / rest - roll_inertia - mass * height**2
    if left <= 0:
        raise InputError(
            f"{name}: without {mass:g} kg at {height:g} m its rear_roll_inertia would be {left:g} kg.m2; "
            "lower saddle or rider"
        )
    return dict(zip(REAR_FRAME, (rest, moment / rest, left), strict=True))
