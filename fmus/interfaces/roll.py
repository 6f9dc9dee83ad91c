"""The roll port: motion of a frame that rolls about an axis, and the forces of a rider who leans on it.

The axis lies on the ground for a vehicle and is the roll axis of a test rig otherwise. A force is positive in the
sense of its velocity. The power into the frame is F v + T_phi p. The lateral acceleration of the frame is v' + a_c; v'
is not an input, because the absolute velocities of the rider are states.
"""

from dataclasses import replace

from fmus.declaration.variables import Variable, input

ROLL = {
    "roll_angle": ("rad", "Roll angle of the frame, lean to the right positive", r"\phi"),
    "roll_rate": ("rad/s", "Roll rate of the frame", "p"),
    "lateral_velocity": ("m/s", "Lateral velocity of the frame at the roll axis; 0 on a test rig", "v"),
    "turning_acceleration": ("m/s2", "Speed times yaw rate; 0 on a test rig", "a_c"),
    "roll_torque": ("N.m", "Roll torque on the rear frame about the roll axis", r"T_\phi"),
    "lateral_force": ("N", "Lateral force on the rear frame at the roll axis, to the right", "F"),
}
FLOWS = ("roll_torque", "lateral_force")


def roll_input(name: str) -> Variable:
    """A variable of the port as an input. Raises KeyError for another name."""
    unit, description, symbol = ROLL[name]
    return input(unit, description, symbol=symbol, port="roll", flow=name in FLOWS)


def roll_output(name: str) -> Variable:
    """A variable of the port as an output."""
    return replace(roll_input(name), role="output")
