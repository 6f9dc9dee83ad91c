"""The steer axis of the riding simulator: servo, torsiometer, handlebar, potentiometer, converters.

    servo         I_m q'' = k_p (q_c - q) - c_p q' - M_s,    I_m = k_p / w_p^2,   c_p = 2 zeta_p k_p / w_p
    torsiometer   M_s = k_s (q - delta) + c_s (q' - s)
    handlebar     I_s s' = M_s + T_h + T_r,    delta' = s,    w = 0
    channels      y = step * round((x + noise) / step)

The servo loop has finite stiffness and bandwidth. T_r is the remnant, the muscle torque of the rider beside the passive
impedance. Noise and remnant are inputs, so that the rig itself is repeatable.

Source: Cossalter et al. (2008), Sect. 2; Meccanica 46 (2011), Sect. 3.1, eq. 5. Neither prints the servo's
values: those here are assumed, stiff enough that the angle counts as imposed, as both papers say.
"""

from math import pi

from fmus import Component, input, local, output, parameter
from fmus.declaration.variables import state
from fmus.interfaces.handlebar import port_input, port_output, port_state
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA


class SteerRig(Component):
    """Servo-driven handlebar with the two measured channels of the rig."""

    steer_inertia = parameter(
        "kg.m2",
        "Inertia about the steer axis, the rider's share included",
        symbol="I_s",
        min=1e-4,
        max=20,
        start=HANDLEBAR_INERTIA,
    )
    shaft_stiffness = parameter("N.m/rad", "Stiffness of the torsiometer", symbol="k_s", min=1, max=1e7, start=5e4)
    shaft_damping = parameter("N.m.s/rad", "Damping of the torsiometer", symbol="c_s", min=0, max=1e4, start=5.0)
    servo_stiffness = parameter(
        "N.m/rad", "Torque of the servo loop per angle error", symbol="k_p", min=1, max=1e7, start=2e4
    )
    servo_bandwidth = parameter(
        "rad/s", "Natural frequency of the unloaded servo loop", symbol="w_p", min=1, max=1e4, start=2 * pi * 40
    )
    servo_damping_ratio = parameter(
        "1", "Damping ratio of the unloaded servo loop", symbol=r"\zeta_p", min=0.01, max=10, start=0.8
    )
    angle_step = parameter("rad", "Resolution of the potentiometer's channel; 0 is none", min=0, max=1)
    torque_step = parameter("N.m", "Resolution of the torsiometer's channel; 0 is none", min=0, max=100)

    steer_angle_command = input("rad", "Commanded angle", symbol="q_c")
    remnant_torque = input("N.m", "Muscle torque of the rider beside the passive impedance", symbol="T_r")
    angle_noise = input("rad", "Noise of the potentiometer")
    torque_noise = input("N.m", "Noise of the strain gauges")
    handlebar_torque = port_input("handlebar_torque")
    frame_torque = port_input("frame_torque")

    servo_angle = state("rad", "Angle of the servo's shaft", symbol="q")
    servo_rate = state("rad/s", "Rate of the servo's shaft", symbol=r"\dot q")
    steer_angle = port_state("steer_angle")
    steer_rate = port_state("steer_rate")
    frame_rate = port_output("frame_rate")
    shaft_torque = local("N.m", "Torque in the torsiometer's shaft", symbol="M_s")
    measured_angle = output("rad", "Steer angle as the potentiometer gives it")
    measured_torque = output("N.m", "Steer torque as the torsiometer gives it")

    def equations(self, v, m):
        v.shaft_torque = v.shaft_stiffness * (v.servo_angle - v.steer_angle) + v.shaft_damping * (
            v.servo_rate - v.steer_rate
        )
        motor_inertia = v.servo_stiffness / v.servo_bandwidth**2
        motor_damping = 2 * v.servo_damping_ratio * v.servo_stiffness / v.servo_bandwidth
        servo_torque = v.servo_stiffness * (v.steer_angle_command - v.servo_angle) - motor_damping * v.servo_rate
        return {
            "der(servo_angle)": v.servo_rate,
            "der(servo_rate)": (servo_torque - v.shaft_torque) / motor_inertia,
            "der(steer_angle)": v.steer_rate,
            "der(steer_rate)": (v.shaft_torque + v.handlebar_torque + v.remnant_torque) / v.steer_inertia,
            "frame_rate": 0.0,
            "measured_angle": m.quantised(v.steer_angle + v.angle_noise, v.angle_step),
            "measured_torque": m.quantised(v.shaft_torque + v.torque_noise, v.torque_step),
        }
