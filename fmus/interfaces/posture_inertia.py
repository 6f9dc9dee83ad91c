"""The inertia of a rider at the handlebar where it changes with his posture: what a vehicle carries besides a constant.

A rider's limbs reflect an inertia R to the steer axis. Its value at rest is the vehicle's `added_steer_inertia`; with

    R = R_rest + inertia_change,      T_h = handlebar_torque - [R (s + w)' + inertia_torque] + R_rest (s + w)'

the vehicle's equations hold R in its mass matrix, and take inertia_torque off the torque at its handlebar, so that no
acceleration is told to the rider.
"""

from dataclasses import replace
from typing import Any

from fmus.effects import Effect, adds_to
from fmus.variables import Variable, input

POSTURE = {
    "inertia_change": ("kg.m2", "Inertia that the limbs reflect to the steer axis, less that at rest", r"\Delta R"),
    "inertia_torque": ("N.m", "Half of the rate of that inertia times the rate of the handlebar", "T_R"),
}


def told_posture(name: str) -> Variable:
    """The variable as an input of whoever carries the inertia."""
    unit, description, symbol = POSTURE[name]
    return input(unit, description, symbol=symbol)


def answers_posture(name: str) -> Variable:
    """The variable as an output of the rider."""
    return replace(told_posture(name), role="output")


class CarriesPosture(Effect):
    """The vehicle carries an inertia at its handlebar that changes with the rider's posture."""

    inertia_change = told_posture("inertia_change")
    inertia_torque = told_posture("inertia_torque")

    @adds_to("added_steer_inertia")
    def inertia(self, v: Any, m: Any) -> Any:
        return v.inertia_change

    @adds_to("handlebar_torque")
    def torque(self, v: Any, m: Any) -> Any:
        return -v.inertia_torque
