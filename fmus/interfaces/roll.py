"""The roll port: a frame that rolls about its axis (of a vehicle: on the ground) and a rider who leans on it.

A force is positive in the sense of its velocity, so the power into the frame is F v + T p. The frame's lateral
acceleration is v' + a_c; v' is not told, because the rider's absolute velocities are states.
"""

from dataclasses import replace

from fmus.variables import Variable, input

ROLL = {
    "roll_angle": ("rad", "Roll angle of the frame, lean to the right positive", r"\phi"),
    "roll_rate": ("rad/s", "Roll rate of the frame", "p"),
    "lateral_velocity": ("m/s", "Lateral velocity of the frame at the roll axis; 0 on a test rig", "v"),
    "turning_acceleration": ("m/s2", "Speed times yaw rate; 0 on a test rig", "a_c"),
    "roll_torque": ("N.m", "Roll torque on the rear frame about the roll axis", r"T_\phi"),
    "lateral_force": ("N", "Lateral force on the rear frame at the roll axis, to the right", "F"),
}
FLOWS = ("roll_torque", "lateral_force")


def roll_told(name: str) -> Variable:
    """The port's variable as an input of whoever is told it."""
    unit, description, symbol = ROLL[name]
    return input(unit, description, symbol=symbol, port="roll", flow=name in FLOWS)


def roll_answers(name: str) -> Variable:
    """The port's variable as an output of whoever computes it."""
    return replace(roll_told(name), role="output")
