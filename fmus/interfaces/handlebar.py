"""The handlebar port: motion of the steer axis from the vehicle to a device, two torques from the device to the
vehicle.

The port has two bodies, front assembly and rear frame, both rotating about the steer axis. A torque is positive in the
sense of its angle (right positive). The power into the vehicle is

    P = T_h (s + w) + T_f w

with the steer rate s, the rate w of the rear frame about the steer axis, the handlebar torque T_h on the front assembly
and the frame torque T_f on the rear frame. Torques of several devices at one port are summed.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

from fmus.declaration.component import Component
from fmus.declaration.variables import Variable, input

MOTION = {
    "steer_angle": ("rad", "Steer angle, front relative to rear frame, right positive", r"\delta"),
    "steer_rate": ("rad/s", "Steer rate, front relative to rear frame", "s"),
    "frame_rate": ("rad/s", "Absolute rate of the rear frame about the steer axis; 0 on a test rig", "w"),
}
TORQUES = {
    "handlebar_torque": ("N.m", "Torque on the front assembly about the steer axis", "T_h"),
    "frame_torque": ("N.m", "Torque on the rear frame about the steer axis", "T_f"),
}


def port_input(name: str) -> Variable:
    """A variable of the port as an input: motion of a device, a torque of a vehicle.

    Raises KeyError for another name.
    """
    unit, description, symbol = {**MOTION, **TORQUES}[name]
    return input(unit, description, symbol=symbol, port="handlebar", flow=name in TORQUES)


def port_output(name: str) -> Variable:
    """A variable of the port as an output: a torque of a device, motion of a vehicle."""
    return replace(port_input(name), role="output")


def port_state(name: str) -> Variable:
    """A variable of the port as an exposed state of a vehicle."""
    return replace(port_input(name), role="state", exposed=True)


class HandlebarDevice(Component):
    """Base class of riders and dampers at the handlebar: the motion is the input, the two torques are the output.

    Every subclass has exactly this port, so that any device can replace any other. `family` and `form` are those of the
    effect that the gap workflow makes of a device (the name of the class by default).

        >>> class Damper(mf.HandlebarDevice):
        ...     "Linear steering damper."
        ...     damping = mf.parameter("N.m.s/rad", "Damping coefficient", min=0, start=7.5)
        ...     def equations(self, v, m):
        ...         torque = -v.damping * v.steer_rate
        ...         return {"handlebar_torque": torque, "frame_torque": -torque}
        >>> Damper("damper").outputs
        ('handlebar_torque', 'frame_torque')
    """

    family: ClassVar[str] = ""
    form: ClassVar[str] = "device"

    steer_angle = port_input("steer_angle")
    steer_rate = port_input("steer_rate")
    frame_rate = port_input("frame_rate")
    handlebar_torque = port_output("handlebar_torque")
    frame_torque = port_output("frame_torque")


def unbound_inertia(subsystems: Mapping[str, Any]) -> str:
    """A hint where FMUs, by name, neglect the inertia that a rider adds at the port; empty where nothing is neglected.

    A rider's FMU gives that inertia as `port_inertia` [kg.m2]. It moves with the handlebar, so that the FMU on the
    other side of the port has to contain it, as its parameter `added_steer_inertia`, from the start.
    """
    known = {name: getattr(each, "variables", {}) for name, each in subsystems.items()}
    riders = [name for name, variables in known.items() if "port_inertia" in variables]
    wanted = sum(subsystems[name].get("port_inertia") for name in riders)
    for name, variables in known.items():
        has_it = name not in riders and "added_steer_inertia" in variables
        if wanted and has_it and subsystems[name].get("added_steer_inertia") == 0.0:
            return (f"{name}.added_steer_inertia is 0, but {' and '.join(riders)} adds {wanted:.6g} kg.m2 to it: "
                    f"start {name} with added_steer_inertia={wanted!r}, "
                    "or use motofmi.cosimulate, which sets it")  # fmt: skip
    return ""


# The power of a torque or force is its product with the sum of these rates; this port and that of
# `fmus.interfaces.roll`.
CONJUGATE_RATES = {"handlebar_torque": ("steer_rate", "frame_rate"), "frame_torque": ("frame_rate",),
            "roll_torque": ("roll_rate",), "lateral_force": ("lateral_velocity",)}  # fmt: skip
