"""What every single-track vehicle declares: steering head, wheels, handlebar port, roll and steer; and, where it moves to the
side, lateral velocity, yaw rate and the roll port.
"""

from typing import Any, ClassVar

from fmus import Component, input, local, parameter, state
from fmus.declaration.elements import Element
from fmus.interfaces.handlebar import port_input, port_output, port_state
from fmus.interfaces.roll import roll_input, roll_output


class SteeredVehicle(Component):
    """Base class of vehicles that roll and steer, with the handlebar port."""

    caster_angle = parameter("rad", "Caster angle of the steer axis", symbol=r"\epsilon", min=-1.5, max=1.5)
    front_wheel_radius = parameter("m", "Radius of the front wheel", symbol="R_f", min=1e-2, max=10, start=0.3)
    rear_wheel_radius = parameter("m", "Radius of the rear wheel", symbol="R_r", min=1e-2, max=10, start=0.3)
    front_spin_inertia = parameter("kg.m2", "Polar inertia of the front wheel", symbol="i_{fy}", min=0, max=1e3)
    rear_spin_inertia = parameter("kg.m2", "Polar inertia of the rear wheel with the engine reflected to it",
                                  symbol="i_{ry}", min=0, max=1e3)  # fmt: skip
    added_steer_inertia = parameter("kg.m2", "Inertia that a rider adds to the front frame about the steer axis",
                                    symbol="I_a", min=-5, max=5, tunable=False)  # fmt: skip
    steering_damping = parameter("N.m.s/rad", "The vehicle's own steering damper", symbol="K", min=0, max=1e4)
    gravity = parameter("m/s2", "Gravitational acceleration", symbol="g", min=0, max=100, start=9.81)

    speed = input("m/s", "Forward speed", symbol="V", min=0.1, max=200, start=30)
    steer_torque = input("N.m", "Disturbance: torque between rear and front frame, on the front frame", symbol="T_d")
    roll_torque = roll_input("roll_torque")
    handlebar_torque = port_input("handlebar_torque")
    frame_torque = port_input("frame_torque")

    roll_rate = state("rad/s", "Roll rate", symbol="p", exposed=True)
    steer_rate = port_state("steer_rate")
    roll_angle = state("rad", "Roll angle, lean to the right positive", symbol=r"\phi", exposed=True)
    steer_angle = port_state("steer_angle")
    frame_rate = port_output("frame_rate")
    head_torque = local("N.m", "Torque of the steering head against the steer rate, such as of a damper", symbol="T_s")

    elements: ClassVar = {
        "steering_head": Element("head_torque", "steer_angle", "steer_rate", damping="steering_damping")
    }


class SidewaysMotion(Component):
    """Base class of vehicles with lateral velocity and yaw rate as states, and the roll port."""

    lateral_force = roll_input("lateral_force")
    lateral_velocity = state("m/s", "Lateral velocity of the origin", symbol="v", exposed=True)
    yaw_rate = state("rad/s", "Yaw rate", symbol="r", exposed=True)
    turning_acceleration = roll_output("turning_acceleration")


class SteeredOnTyres(SidewaysMotion, SteeredVehicle):
    """Base class of vehicles on tyres: lateral velocity, yaw, roll and steer, in this order."""


def port_torques(v: Any, m: Any) -> dict[str, Any]:
    """The generalised forces of the inputs on yaw, roll, lateral motion and steer, with the torque of the steering
    head."""
    torque = v.handlebar_torque + v.frame_torque
    return {
        "lateral_velocity": v.lateral_force,
        "yaw_rate": torque * m.cos(v.caster_angle),
        "roll_rate": torque * m.sin(v.caster_angle) + v.roll_torque,
        "steer_rate": v.handlebar_torque + v.steer_torque - v.head_torque,
    }


def port_motion(v: Any, m: Any) -> dict[str, Any]:
    """The outputs of both ports."""
    frame_rate = v.yaw_rate * m.cos(v.caster_angle) + v.roll_rate * m.sin(v.caster_angle)
    return {"frame_rate": frame_rate, "turning_acceleration": v.speed * v.yaw_rate}
