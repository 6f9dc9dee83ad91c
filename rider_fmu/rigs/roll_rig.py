"""The roll axis of the riding simulator: a servo by which the mock-up follows a commanded angle.

    phi'' = w_p^2 (phi_c - phi) - 2 zeta_p w_p phi'

The mock-up is heavy and geared, so that the rider does not affect its motion. Source of the test: Cossalter et al.
(2008), Sect. 4; the servo's values are assumed.
"""

from math import pi

from fmus import Component, input, output, parameter
from fmus.declaration.variables import state


class RollRig(Component):
    """Servo of the roll axis."""

    servo_bandwidth = parameter(
        "rad/s", "Natural frequency of the servo loop", symbol="w_p", min=1, max=1e4, start=2 * pi * 15
    )
    servo_damping_ratio = parameter(
        "1", "Damping ratio of the servo loop", symbol=r"\zeta_p", min=0.01, max=10, start=0.8
    )
    roll_angle_command = input("rad", "Commanded roll angle", symbol=r"\phi_c")
    roll_angle = state("rad", "Roll angle of the mock-up, right positive", symbol=r"\phi", exposed=True)
    roll_rate = state("rad/s", "Roll rate of the mock-up", symbol=r"\dot\phi", exposed=True)
    roll_acceleration = output("rad/s2", "Roll acceleration of the mock-up", symbol=r"\alpha")

    def equations(self, v, m):
        acceleration = (
            v.servo_bandwidth**2 * (v.roll_angle_command - v.roll_angle)
            - 2 * v.servo_damping_ratio * v.servo_bandwidth * v.roll_rate
        )
        return {"der(roll_angle)": v.roll_rate, "der(roll_rate)": acceleration, "roll_acceleration": acceleration}
