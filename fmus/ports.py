"""Ports: the names under which components meet, each declared once and seen from its two sides.

The handlebar port has two bodies, the front assembly and the rear frame, both about the steer axis. A
torque is positive in the sense of its angle, so the power into the vehicle is
T_h (s + w) + T_f w.
"""

from dataclasses import replace

from fmus.component import Component
from fmus.variables import Variable, input

MOTION = {
    "steer_angle": ("rad", "Steer angle, front relative to rear frame, right positive", r"\delta"),
    "steer_rate": ("rad/s", "Steer rate, front relative to rear frame", "s"),
    "frame_rate": ("rad/s", "Absolute rate of the rear frame about the steer axis; 0 on a test rig", "w"),
}
TORQUES = {
    "handlebar_torque": ("N.m", "Torque on the front assembly about the steer axis", "T_h"),
    "frame_torque": ("N.m", "Torque on the rear frame about the steer axis", "T_f"),
}


def told(name: str) -> Variable:
    """The port's variable as an input of whoever is told it."""
    unit, description, symbol = {**MOTION, **TORQUES}[name]
    return input(unit, description, symbol=symbol, port="handlebar", flow=name in TORQUES)


def answers(name: str) -> Variable:
    """The port's variable as an output of whoever computes it."""
    return replace(told(name), role="output")


def carries(name: str) -> Variable:
    """The port's variable as a state of a vehicle, which it also answers."""
    return replace(told(name), role="state", exposed=True)


class HandlebarDevice(Component):
    """Whatever can be held at the handlebar: told the motion, it answers the two torques."""

    steer_angle = told("steer_angle")
    steer_rate = told("steer_rate")
    frame_rate = told("frame_rate")
    handlebar_torque = answers("handlebar_torque")
    frame_torque = answers("frame_torque")


# The rates whose sum a torque or force works on, of this port and of the roll port (see `fmus.roll_port`).
WORKS_ON = {"handlebar_torque": ("steer_rate", "frame_rate"), "frame_torque": ("frame_rate",),
            "roll_torque": ("roll_rate",), "lateral_force": ("lateral_velocity",)}  # fmt: skip
