"""The Carvallo-Whipple bicycle: four rigid bodies, knife-edge wheels that roll without slip.

    M q'' + V C1 q' + (g K0 + V^2 K2) q = f,   q = (roll, steer),
    yaw rate r = (V delta + c s) cos(eps) / w_b

c is the trail measured on the ground, w_b the wheelbase. A torque T_f about the steer axis on the rear frame
and T_h on the front assembly do the virtual work T_h (s + w) + T_f w, w = r cos(eps) + p sin(eps), with
the virtual yaw c cos(eps) / w_b of a steer displacement.

Source: Meijaard, Papadopoulos, Ruina, Schwab, Proc. R. Soc. A 463 (2007) 1955-1982, Appendix A, whose x is
forward, y right, z down; positions are of the rear contact's frame.
"""

from fmus import Component, input, parameter, state
from fmus.ports import answers, carries, told
from vehicle_fmu.motorcycle import symmetric


class Bicycle(Component):
    """Carvallo-Whipple bicycle with the handlebar port of the motorcycle."""

    wheelbase = parameter("m", "Wheelbase", symbol="w_b", min=0.05, max=10, start=1.02)
    ground_trail = parameter("m", "Trail, measured on the ground", symbol="c", min=-1, max=2, start=0.08)
    caster_angle = parameter("rad", "Tilt of the steer axis", symbol=r"\epsilon", min=-1.5, max=1.5, start=0.31415926535897931)
    gravity = parameter("m/s2", "Gravitational acceleration", symbol="g", min=0, max=100, start=9.81)
    rear_wheel_radius = parameter("m", "Radius of the rear wheel", symbol="r_R", min=1e-2, max=10, start=0.3)
    rear_wheel_mass = parameter("kg", "Mass of the rear wheel", symbol="m_R", min=0, max=1e3)
    rear_wheel_inertia = parameter("kg.m2", "Inertia of the rear wheel about a diameter", symbol="I_{Rxx}", min=0, max=1e3)
    rear_spin_inertia = parameter("kg.m2", "Polar inertia of the rear wheel", symbol="I_{Ryy}", min=0, max=1e3)
    rear_frame_x = parameter("m", "Mass centre of the rear frame ahead of the rear contact", symbol="x_B", min=-10, max=10)
    rear_frame_z = parameter("m", "Mass centre of the rear frame, down", symbol="z_B", min=-10, max=10)
    rear_frame_mass = parameter("kg", "Mass of the rear frame with the rigid rider", symbol="m_B", min=0, max=1e5)
    rear_frame_xx = parameter("kg.m2", "Roll inertia of the rear frame", symbol="I_{Bxx}", min=0, max=1e5)
    rear_frame_zz = parameter("kg.m2", "Yaw inertia of the rear frame", symbol="I_{Bzz}", min=0, max=1e5)
    rear_frame_xz = parameter("kg.m2", "Minus the integral of x z dm of the rear frame", symbol="I_{Bxz}", min=-1e5, max=1e5)
    front_frame_x = parameter("m", "Mass centre of the front frame ahead of the rear contact", symbol="x_H", min=-10, max=10)
    front_frame_z = parameter("m", "Mass centre of the front frame, down", symbol="z_H", min=-10, max=10)
    front_frame_mass = parameter("kg", "Mass of the front frame", symbol="m_H", min=0, max=1e4)
    front_frame_xx = parameter("kg.m2", "Roll inertia of the front frame", symbol="I_{Hxx}", min=0, max=1e4)
    front_frame_zz = parameter("kg.m2", "Yaw inertia of the front frame", symbol="I_{Hzz}", min=0, max=1e4)
    front_frame_xz = parameter("kg.m2", "Minus the integral of x z dm of the front frame", symbol="I_{Hxz}", min=-1e4, max=1e4)
    front_wheel_radius = parameter("m", "Radius of the front wheel", symbol="r_F", min=1e-2, max=10, start=0.35)
    front_wheel_mass = parameter("kg", "Mass of the front wheel", symbol="m_F", min=0, max=1e3)
    front_wheel_inertia = parameter("kg.m2", "Inertia of the front wheel about a diameter", symbol="I_{Fxx}", min=0, max=1e3)
    front_spin_inertia = parameter("kg.m2", "Polar inertia of the front wheel", symbol="I_{Fyy}", min=0, max=1e3)
    added_steer_inertia = parameter("kg.m2", "Inertia that a rider adds to the front frame about the steer axis", symbol="I_a", min=-5, max=5, tunable=False)
    steering_damping = parameter("N.m.s/rad", "The bicycle's own steering damper", symbol="K", min=0, max=1e4)

    speed = input("m/s", "Forward speed", symbol="V", min=0, max=200, start=5)
    steer_torque = input("N.m", "Disturbance: torque between rear and front frame, on the front frame", symbol="T_d")
    roll_torque = input("N.m", "Disturbance: roll torque on the rear frame", symbol=r"T_\phi")
    handlebar_torque = told("handlebar_torque")
    frame_torque = told("frame_torque")

    roll_rate = state("rad/s", "Roll rate", symbol="p", exposed=True)
    steer_rate = carries("steer_rate")
    roll_angle = state("rad", "Roll angle, lean to the right positive", symbol=r"\phi", exposed=True)
    steer_angle = carries("steer_angle")
    frame_rate = answers("frame_rate")

    def mass(self, v, m):
        b = assembled(v, m)
        return symmetric(("roll_rate", "steer_rate"), [[b.T_xx, b.F_lx + b.mu * b.T_xz],
                                                       [b.F_ll + 2 * b.mu * b.F_lz + b.mu**2 * b.T_zz]])  # fmt: skip

    def equations(self, v, m):
        b = assembled(v, m)
        V, g, S = v.speed, v.gravity, m.sin(v.caster_angle)
        turn = m.cos(v.caster_angle) / v.wheelbase
        p, s, phi, delta = v.roll_rate, v.steer_rate, v.roll_angle, v.steer_angle
        C_rs = b.mu * b.S_T + b.S_F * m.cos(v.caster_angle) + b.T_xz * turn - b.mu * b.m_z
        C_sr = -(b.mu * b.S_T + b.S_F * m.cos(v.caster_angle))
        C_ss = b.F_lz * turn + b.mu * (b.S_A + b.T_zz * turn)
        rate = turn * (V * delta + v.ground_trail * s)
        torque = v.handlebar_torque + v.frame_torque
        return {
            "der(roll_rate)": torque * S + v.roll_torque - V * C_rs * s - g * (b.m_z * phi - b.S_A * delta)
                              - V**2 * (b.S_T - b.m_z) * turn * delta,
            "der(steer_rate)": v.handlebar_torque + torque * b.mu * m.cos(v.caster_angle) + v.steer_torque
                               - v.steering_damping * s - V * (C_sr * p + C_ss * s)
                               + g * b.S_A * (phi + S * delta) - V**2 * (b.S_A + b.S_F * S) * turn * delta,
            "der(roll_angle)": p,
            "der(steer_angle)": s,
            "frame_rate": rate * m.cos(v.caster_angle) + p * S,
        }  # fmt: skip


class assembled:  # noqa: N801 - a bundle of the paper's symbols, not a type of the domain
    """The sums over the bodies that the paper's Appendix A forms, under its symbols."""

    def __init__(self, v, m):
        c, S, w = m.cos(v.caster_angle), m.sin(v.caster_angle), v.wheelbase
        rotor = v.front_frame_mass + v.front_wheel_mass
        total = v.rear_wheel_mass + v.rear_frame_mass + rotor
        x_total = (v.rear_frame_x * v.rear_frame_mass + v.front_frame_x * v.front_frame_mass + w * v.front_wheel_mass) / total
        self.m_z = (-v.rear_wheel_radius * v.rear_wheel_mass + v.rear_frame_z * v.rear_frame_mass
                    + v.front_frame_z * v.front_frame_mass - v.front_wheel_radius * v.front_wheel_mass)  # fmt: skip
        self.T_xx = (v.rear_wheel_inertia + v.rear_frame_xx + v.front_frame_xx + v.front_wheel_inertia
                     + v.rear_wheel_mass * v.rear_wheel_radius**2 + v.rear_frame_mass * v.rear_frame_z**2
                     + v.front_frame_mass * v.front_frame_z**2 + v.front_wheel_mass * v.front_wheel_radius**2)  # fmt: skip
        self.T_xz = (v.rear_frame_xz + v.front_frame_xz - v.rear_frame_mass * v.rear_frame_x * v.rear_frame_z
                     - v.front_frame_mass * v.front_frame_x * v.front_frame_z
                     + v.front_wheel_mass * w * v.front_wheel_radius)  # fmt: skip
        self.T_zz = (v.rear_wheel_inertia + v.rear_frame_zz + v.front_frame_zz + v.front_wheel_inertia
                     + v.rear_frame_mass * v.rear_frame_x**2 + v.front_frame_mass * v.front_frame_x**2
                     + v.front_wheel_mass * w**2)  # fmt: skip
        x_A = (v.front_frame_x * v.front_frame_mass + w * v.front_wheel_mass) / rotor
        z_A = (v.front_frame_z * v.front_frame_mass - v.front_wheel_radius * v.front_wheel_mass) / rotor
        A_xx = (v.front_frame_xx + v.front_wheel_inertia + v.front_frame_mass * (v.front_frame_z - z_A) ** 2
                + v.front_wheel_mass * (v.front_wheel_radius + z_A) ** 2)  # fmt: skip
        A_xz = (v.front_frame_xz - v.front_frame_mass * (v.front_frame_x - x_A) * (v.front_frame_z - z_A)
                + v.front_wheel_mass * (w - x_A) * (v.front_wheel_radius + z_A))  # fmt: skip
        A_zz = (v.front_frame_zz + v.front_wheel_inertia + v.front_frame_mass * (v.front_frame_x - x_A) ** 2
                + v.front_wheel_mass * (w - x_A) ** 2)  # fmt: skip
        lever = (x_A - w - v.ground_trail) * c - z_A * S
        self.F_ll = rotor * lever**2 + A_xx * S**2 + 2 * A_xz * S * c + A_zz * c**2 + v.added_steer_inertia
        self.F_lx = -rotor * lever * z_A + A_xx * S + A_xz * c + v.added_steer_inertia * S
        self.F_lz = rotor * lever * x_A + A_xz * S + A_zz * c + v.added_steer_inertia * c
        self.T_xx += v.added_steer_inertia * S**2
        self.T_xz += v.added_steer_inertia * S * c
        self.T_zz += v.added_steer_inertia * c**2
        self.mu = v.ground_trail * c / w
        self.S_F = v.front_spin_inertia / v.front_wheel_radius
        self.S_T = v.rear_spin_inertia / v.rear_wheel_radius + self.S_F
        self.S_A = rotor * lever + (v.ground_trail / w) * c * total * x_total
