"""The Carvallo-Whipple bicycle: four rigid bodies, knife-edge wheels rolling without slip.

    M q'' + V C1 q' + (g K0 + V^2 K2) q = f,   q = (roll, steer),
    yaw rate r = (V delta + c s) cos(eps) / w_b

c is the trail measured on the ground, w_b the wheelbase. A torque T_f about the steer axis on the rear frame
and T_h on the front assembly do the virtual work T_h (s + w) + T_f w, w = r cos(eps) + p sin(eps), with
the virtual yaw c cos(eps) / w_b of a steer displacement.

Source: Meijaard, Papadopoulos, Ruina, Schwab, Proc. R. Soc. A 463 (2007) 1955-1982, Appendix A, whose x is
forward, y right, z down; positions are of the rear contact's frame.
"""

from fmus import input, local
from vehicle_fmu.bicycle_bodies import BicycleBodies
from vehicle_fmu.components.motorcycle import symmetric


class Bicycle(BicycleBodies):
    """Carvallo-Whipple bicycle with the handlebar port of the motorcycle."""

    speed = input("m/s", "Forward speed", symbol="V", min=0, max=200, start=5)
    roll_torque = input("N.m", "Disturbance: roll torque on the rear frame", symbol=r"T_\phi")


    mass_moment = local("kg.m", "Mass of all bodies times the height of their mass centre, z down", symbol="m_T z_T")
    total_roll_inertia = local("kg.m2", "Inertia of all bodies about the axis x", symbol="I_{Txx}")
    total_product = local("kg.m2", "Product of inertia of all bodies", symbol="I_{Txz}")
    total_yaw_inertia = local("kg.m2", "Inertia of all bodies about the axis z", symbol="I_{Tzz}")
    front_mass = local("kg", "Mass of the front assembly", symbol="m_A")
    front_x = local("m", "Mass centre of the front assembly ahead of the rear contact", symbol="x_A")
    front_z = local("m", "Mass centre of the front assembly, down", symbol="z_A")
    front_roll_inertia = local("kg.m2", "Roll inertia of the front assembly about its mass centre", symbol="I_{Axx}")
    front_product = local("kg.m2", "Product of inertia of the front assembly about its mass centre", symbol="I_{Axz}")
    front_yaw_inertia = local("kg.m2", "Yaw inertia of the front assembly about its mass centre", symbol="I_{Azz}")
    front_lever = local("m", "Mass centre of the front assembly ahead of the steer axis", symbol="u_A")
    steer_steer_inertia = local(
        "kg.m2", "Inertia of the front assembly about the steer axis", symbol=r"I_{A\lambda\lambda}"
    )
    steer_roll_inertia = local("kg.m2", "Its product between steer axis and axis x", symbol=r"I_{A\lambda x}")
    steer_yaw_inertia = local("kg.m2", "Its product between steer axis and axis z", symbol=r"I_{A\lambda z}")
    trail_ratio = local("1", "Mechanical trail per wheelbase", symbol=r"\mu")
    front_spin_per_speed = local("kg.m", "Spin momentum of the front wheel per speed", symbol="S_F")
    total_spin_per_speed = local("kg.m", "Spin momentum of both wheels per speed", symbol="S_T")
    static_moment = local("kg.m", "Static moment that gravity works on when steered", symbol="S_A")

    def mass(self, v, m):
        assemble(v, m)
        mu, F_lz = v.trail_ratio, v.steer_yaw_inertia
        return symmetric(("roll_rate", "steer_rate"),
                         [[v.total_roll_inertia, v.steer_roll_inertia + mu * v.total_product],
                          [v.steer_steer_inertia + 2 * mu * F_lz + mu**2 * v.total_yaw_inertia]])  # fmt: skip

    def equations(self, v, m):
        assemble(v, m)
        V, g, c, S = v.speed, v.gravity, m.cos(v.caster_angle), m.sin(v.caster_angle)
        turn = c / v.wheelbase
        mu, S_F, S_T, S_A, m_z = (
            v.trail_ratio,
            v.front_spin_per_speed,
            v.total_spin_per_speed,
            v.static_moment,
            v.mass_moment,
        )
        p, s, phi, delta = v.roll_rate, v.steer_rate, v.roll_angle, v.steer_angle
        C_rs = mu * S_T + S_F * c + v.total_product * turn - mu * m_z
        C_sr = -(mu * S_T + S_F * c)
        C_ss = v.steer_yaw_inertia * turn + mu * (S_A + v.total_yaw_inertia * turn)
        rate = turn * (V * delta + v.ground_trail * s)
        torque = v.handlebar_torque + v.frame_torque
        v.head_torque = v.steering_damping * s
        return {
            "der(roll_rate)": torque * S + v.roll_torque - V * C_rs * s - g * (m_z * phi - S_A * delta)
                              - V**2 * (S_T - m_z) * turn * delta,
            "der(steer_rate)": v.handlebar_torque + torque * mu * c + v.steer_torque
                               - v.head_torque - V * (C_sr * p + C_ss * s)
                               + g * S_A * (phi + S * delta) - V**2 * (S_A + S_F * S) * turn * delta,
            "der(roll_angle)": p,
            "der(steer_angle)": s,
            "frame_rate": rate * c + p * S,
        }  # fmt: skip


def assemble(v, m):
    """Set the sums over the bodies of the paper's Appendix A, the inertia added by a rider included."""
    c, S, w_b, share = m.cos(v.caster_angle), m.sin(v.caster_angle), v.wheelbase, v.added_steer_inertia
    mR, rR, mB, xB, zB = v.rear_wheel_mass, v.rear_wheel_radius, v.rear_frame_mass, v.rear_frame_x, v.rear_frame_z
    mH, xH, zH, mF, rF = v.front_frame_mass, v.front_frame_x, v.front_frame_z, v.front_wheel_mass, v.front_wheel_radius
    v.mass_moment = -rR * mR + zB * mB + zH * mH - rF * mF
    v.total_roll_inertia = (v.rear_wheel_inertia + v.rear_frame_xx + v.front_frame_xx + v.front_wheel_inertia
                            + mR * rR**2 + mB * zB**2 + mH * zH**2 + mF * rF**2 + share * S**2)  # fmt: skip
    v.total_product = v.rear_frame_xz + v.front_frame_xz - mB * xB * zB - mH * xH * zH + mF * w_b * rF + share * S * c
    v.total_yaw_inertia = (v.rear_wheel_inertia + v.rear_frame_zz + v.front_frame_zz + v.front_wheel_inertia
                           + mB * xB**2 + mH * xH**2 + mF * w_b**2 + share * c**2)  # fmt: skip
    v.front_mass = mH + mF
    v.front_x = (xH * mH + w_b * mF) / v.front_mass
    v.front_z = (zH * mH - rF * mF) / v.front_mass
    x_A, z_A = v.front_x, v.front_z
    v.front_roll_inertia = v.front_frame_xx + v.front_wheel_inertia + mH * (zH - z_A) ** 2 + mF * (rF + z_A) ** 2
    v.front_product = v.front_frame_xz - mH * (xH - x_A) * (zH - z_A) + mF * (w_b - x_A) * (rF + z_A)
    v.front_yaw_inertia = v.front_frame_zz + v.front_wheel_inertia + mH * (xH - x_A) ** 2 + mF * (w_b - x_A) ** 2
    v.front_lever = (x_A - w_b - v.ground_trail) * c - z_A * S
    moment = v.front_mass * v.front_lever
    v.steer_steer_inertia = (moment * v.front_lever + v.front_roll_inertia * S**2 + 2 * v.front_product * S * c
                             + v.front_yaw_inertia * c**2 + share)  # fmt: skip
    v.steer_roll_inertia = -moment * z_A + v.front_roll_inertia * S + v.front_product * c + share * S
    v.steer_yaw_inertia = moment * x_A + v.front_product * S + v.front_yaw_inertia * c + share * c
    v.trail_ratio = v.ground_trail * c / w_b
    v.front_spin_per_speed = v.front_spin_inertia / rF
    v.total_spin_per_speed = v.rear_spin_inertia / rR + v.front_spin_per_speed
    v.static_moment = moment + v.trail_ratio * (xB * mB + xH * mH + w_b * mF)
