"""The test rig's handlebar: one body about the steer axis, on a frame that stands still.

    (I_s + I_a) s' = M_s + T_h,   delta' = s,   w = 0

Source: Cossalter et al., Meccanica 46 (2011), eq. 5.
"""

from fmus import Component, input, output, parameter
from fmus.ports import answers, carries, told


class Handlebar(Component):
    """The bar of the steer test rig, driven by the servo's torque."""

    steer_inertia = parameter("kg.m2", "Inertia about the steer axis, the rider's share included", symbol="I_s", min=1e-4, max=20, start=0.125)
    added_steer_inertia = parameter("kg.m2", "Inertia that a rider adds, where steer_inertia is the bare bar's", symbol="I_a", min=-5, max=5, tunable=False)
    servo_torque = input("N.m", "Torque of the servo, as the torsiometer measures it", symbol="M_s")
    handlebar_torque = told("handlebar_torque")
    frame_torque = told("frame_torque")
    steer_angle = carries("steer_angle")
    steer_rate = carries("steer_rate")
    frame_rate = answers("frame_rate")
    steer_acceleration = output("rad/s2", "Angular acceleration of the bar", symbol=r"\dot s")

    def equations(self, v, m):
        acceleration = (v.servo_torque + v.handlebar_torque) / (v.steer_inertia + v.added_steer_inertia)
        return {
            "der(steer_angle)": v.steer_rate,
            "der(steer_rate)": acceleration,
            "frame_rate": 0.0,
            "steer_acceleration": acceleration,
        }
