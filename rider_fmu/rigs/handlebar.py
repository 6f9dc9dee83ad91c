"""The handlebar of the test rig: one body about the steer axis, on a fixed frame.

    (I_s + I_a) s' = M_s + T_h,   delta' = s,   w = 0

Source: Cossalter et al., Meccanica 46 (2011), eq. 5.
"""

from fmus import Component, input, output, parameter
from fmus.interfaces.handlebar import port_input, port_output, port_state

# Kg.m2, the bare bar of the 2011 rig: steer inertia of the mean rider's test in Table 2, whose rider adds none
HANDLEBAR_INERTIA = 0.125


class Handlebar(Component):
    """Handlebar of the steer test rig, driven by the torque of a servo."""

    steer_inertia = parameter(
        "kg.m2",
        "Inertia about the steer axis, the rider's share included",
        symbol="I_s",
        min=1e-4,
        max=20,
        start=HANDLEBAR_INERTIA,
    )
    added_steer_inertia = parameter(
        "kg.m2",
        "Inertia that a rider adds, where steer_inertia is the bare bar's",
        symbol="I_a",
        min=-5,
        max=5,
        tunable=False,
    )
    servo_torque = input("N.m", "Torque of the servo, as the torsiometer measures it", symbol="M_s")
    handlebar_torque = port_input("handlebar_torque")
    frame_torque = port_input("frame_torque")
    steer_angle = port_state("steer_angle")
    steer_rate = port_state("steer_rate")
    frame_rate = port_output("frame_rate")
    steer_acceleration = output("rad/s2", "Angular acceleration of the bar", symbol=r"\dot s")

    def equations(self, v, m):
        acceleration = (v.servo_torque + v.handlebar_torque) / (v.steer_inertia + v.added_steer_inertia)
        return {
            "der(steer_angle)": v.steer_rate,
            "der(steer_rate)": acceleration,
            "frame_rate": 0.0,
            "steer_acceleration": acceleration,
        }
