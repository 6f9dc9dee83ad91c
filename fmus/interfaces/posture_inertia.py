"""The inertia of a rider about the steer axis, where it changes with posture.

The limbs of a rider add an inertia R about the steer axis. Its value at rest is the vehicle's `added_steer_inertia`.
With

    R = R_rest + inertia_change,      T_h = handlebar_torque - [R (s + w)' + inertia_torque] + R_rest (s + w)'

the vehicle has R in its mass matrix and subtracts inertia_torque from the torque at its handlebar. The rider then
needs no acceleration as input.
"""

from dataclasses import replace
from typing import Any

from fmus.declaration.variables import Variable, input
from fmus.effects import Effect, adds_to

POSTURE = {
    "inertia_change": ("kg.m2", "Inertia that the limbs reflect to the steer axis, less that at rest", r"\Delta R"),
    "inertia_torque": ("N.m", "Half of the rate of that inertia times the rate of the handlebar", "T_R"),
}


def posture_input(name: str) -> Variable:
    """The variable as an input of the vehicle."""
    unit, description, symbol = POSTURE[name]
    return input(unit, description, symbol=symbol)


def posture_output(name: str) -> Variable:
    """The variable as an output of the rider."""
    return replace(posture_input(name), role="output")


class PostureInertia(Effect):
    """The vehicle includes an inertia at its handlebar that changes with the posture of the rider."""

    inertia_change = posture_input("inertia_change")
    inertia_torque = posture_input("inertia_torque")

    @adds_to("added_steer_inertia")
    def inertia(self, v: Any, m: Any) -> Any:
        return v.inertia_change

    @adds_to("handlebar_torque")
    def torque(self, v: Any, m: Any) -> Any:
        return -v.inertia_torque
