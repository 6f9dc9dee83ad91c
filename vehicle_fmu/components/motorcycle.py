"""The motorcycle of Sharp (1971) with relaxing tyres: the out-of-plane motion in straight running.

Axes: x forward, y right, z down, origin on the ground below the rear frame's mass centre. Unknowns: lateral
velocity v, yaw rate r, roll rate p, steer rate s, and the side forces Y_f, Y_r. With c = cos(eps), S = sin(eps),
the spin momenta h_f = V i_fy / R_f, h_r = V i_ry / R_r and G = -Z_f t + M_f e g:

    lateral  M_1 q + (M_f + M_r) V r                                              = Y_f + Y_r + F
    yaw      M_2 q + M_f k V r - (h_f + h_r) p - h_f S s                          = l Y_f - b Y_r + (T_h + T_f) c
    roll     M_3 q + (M_f j + M_r h) (V r - g phi) + (h_f + h_r) r + h_f c s - G delta = (T_h + T_f) S + T_phi
    steer    M_4 q + M_f e V r + h_f (S r - c p) + K s - G (phi + S delta)         = -t Y_f + T_h
    tyres    (sigma_f / V) Y_f' + Y_f = C_f1 (delta c - (v + l r - t s) / V) + C_f2 (phi + delta S)
             (sigma_r / V) Y_r' + Y_r = C_r1 (-(v - b r) / V) + C_r2 phi

q = (v', r', p', s'). Conventions that Sharp's printed eigenvalues confirm: f is measured upward along the steer axis,
the trail t perpendicular to it; camber thrust relaxes too, on both tyres; C_rxz = + integral of x z dm with z
down, which is minus Meijaard's I_xz; Z_f is negative (load on the tyre, z down).

Source: Sharp, J. Mech. Eng. Sci. 13(5) (1971) 316-329; the torques of the port: Cossalter et al., Meccanica 46
(2011) 279-292, where the rider inertia I_a is added to I_fz everywhere.
"""

from fmus import local, parameter
from vehicle_fmu.relaxing_tyres import RelaxingTyres, relaxed
from vehicle_fmu.steered_vehicle import SteeredOnTyres, port_motion, port_torques


class Motorcycle(SteeredOnTyres, RelaxingTyres):
    """Motorcycle with a rigid rear frame (rider included), a front frame and two relaxing tyres."""

    front_mass = parameter("kg", "Mass of the front frame", symbol="M_f", min=0, max=1e4)
    rear_mass = parameter("kg", "Mass of the rear frame with the rigid rider", symbol="M_r", min=1e-3, max=1e5)
    front_tyre_load = parameter("N", "Vertical load on the front tyre, z down: negative", symbol="Z_f", max=0, min=-1e6)
    rear_roll_inertia = parameter(
        "kg.m2", "Roll inertia of the rear frame about its mass centre", symbol="I_{rx}", min=0, max=1e5
    )
    rear_yaw_inertia = parameter(
        "kg.m2", "Yaw inertia of the rear frame about its mass centre", symbol="I_{rz}", min=0, max=1e5
    )
    rear_product_of_inertia = parameter(
        "kg.m2", "Integral of x z dm of the rear frame, z down", symbol="C_{rxz}", min=-1e5, max=1e5
    )
    front_cross_inertia = parameter(
        "kg.m2", "Inertia of the front frame perpendicular to the steer axis", symbol="I_{fx}", min=0, max=1e4
    )
    front_steer_inertia = parameter(
        "kg.m2",
        "Inertia of the front frame about an axis parallel to the steer axis through its mass centre",
        symbol="I_{fz}",
        min=1e-6,
        max=1e4,
    )
    front_product_of_inertia = parameter(
        "kg.m2", "Product of inertia of the front frame in its own axes", symbol="I_{fxz}", min=-1e4, max=1e4
    )
    steer_axis_distance = parameter(
        "m", "Perpendicular distance from the origin to the steer axis", symbol="a", min=0, max=10
    )
    rear_contact_distance = parameter("m", "Origin to the rear contact, backwards", symbol="b", min=0, max=10)
    front_mass_offset = parameter("m", "Front mass centre ahead of the steer axis", symbol="e", min=-2, max=2)
    front_mass_rise = parameter(
        "m", "Front mass centre above the foot of a, upward along the steer axis", symbol="f", min=-5, max=5
    )
    rear_mass_height = parameter("m", "Height of the rear frame's mass centre", symbol="h", min=0, max=10)
    trail = parameter("m", "Trail, perpendicular to the steer axis", symbol="t", min=-1, max=1)
    front_cornering_stiffness = parameter(
        "N/rad", "Side force per slip angle of the front tyre", symbol="C_{f1}", min=0, max=1e12
    )
    front_camber_stiffness = parameter(
        "N/rad", "Side force per camber angle of the front tyre", symbol="C_{f2}", min=-1e9, max=1e9
    )
    rear_cornering_stiffness = parameter(
        "N/rad", "Side force per slip angle of the rear tyre", symbol="C_{r1}", min=0, max=1e12
    )
    rear_camber_stiffness = parameter(
        "N/rad", "Side force per camber angle of the rear tyre", symbol="C_{r2}", min=-1e9, max=1e9
    )
    gravity = parameter("m/s2", "Gravitational acceleration", symbol="g", min=0, max=100, start=9.80665)

    front_contact_distance = local("m", "Origin to the front contact, forwards", symbol="l")
    front_mass_distance = local("m", "Origin to the front mass centre, forwards", symbol="k")
    front_mass_height = local("m", "Height of the front mass centre", symbol="j")
    ridden_steer_inertia = local("kg.m2", "Inertia I_fz with the rider's share", symbol="I_s")
    front_roll_inertia = local("kg.m2", "Inertia of the front frame about the axis x", symbol="I_{xf}")
    front_yaw_inertia = local("kg.m2", "Inertia of the front frame about the axis z", symbol="I_{zf}")
    front_roll_yaw_product = local("kg.m2", "Product of inertia of the front frame in the axes x and z", symbol="C_f")
    front_spin_momentum = local("N.m.s", "Spin momentum of the front wheel", symbol="h_f")
    rear_spin_momentum = local("N.m.s", "Spin momentum of the rear wheel", symbol="h_r")
    tilt_moment = local("N.m/rad", "Steer moment of the front frame's weight and load per roll angle", symbol="G")

    def mass(self, v, m):
        place_front_frame(v, m)
        c, S = m.cos(v.caster_angle), m.sin(v.caster_angle)
        k, j, e, h = v.front_mass_distance, v.front_mass_height, v.front_mass_offset, v.rear_mass_height
        Mf, Mr, Ifx, Ifxz = v.front_mass, v.rear_mass, v.front_cross_inertia, v.front_product_of_inertia
        v.ridden_steer_inertia = v.front_steer_inertia + v.added_steer_inertia
        v.front_roll_inertia = Ifx * c**2 + v.ridden_steer_inertia * S**2 + 2 * Ifxz * S * c
        v.front_yaw_inertia = Ifx * S**2 + v.ridden_steer_inertia * c**2 - 2 * Ifxz * S * c
        v.front_roll_yaw_product = (v.ridden_steer_inertia - Ifx) * S * c + Ifxz * (c**2 - S**2)
        return symmetric(
            ("lateral_velocity", "yaw_rate", "roll_rate", "steer_rate"),
            [
                [Mf + Mr, Mf * k, Mf * j + Mr * h, Mf * e],
                [v.rear_yaw_inertia + v.front_yaw_inertia + Mf * k**2,
                 Mf * j * k - v.rear_product_of_inertia + v.front_roll_yaw_product,
                 Mf * e * k + v.ridden_steer_inertia * c - Ifxz * S],
                [v.rear_roll_inertia + v.front_roll_inertia + Mr * h**2 + Mf * j**2,
                 Mf * e * j + v.ridden_steer_inertia * S + Ifxz * c],
                [v.ridden_steer_inertia + Mf * e**2],
            ],
        )  # fmt: skip

    def equations(self, v, m):
        place_front_frame(v, m)
        c, S = m.cos(v.caster_angle), m.sin(v.caster_angle)
        l, k, j = v.front_contact_distance, v.front_mass_distance, v.front_mass_height
        V, g = v.speed, v.gravity
        v.front_spin_momentum = V * v.front_spin_inertia / v.front_wheel_radius
        v.rear_spin_momentum = V * v.rear_spin_inertia / v.rear_wheel_radius
        v.tilt_moment = -v.front_tyre_load * v.trail + v.front_mass * v.front_mass_offset * g
        spin, tilt = v.front_spin_momentum + v.rear_spin_momentum, v.tilt_moment
        roll_moment = v.front_mass * j + v.rear_mass * v.rear_mass_height
        r, p, s, phi, delta = v.yaw_rate, v.roll_rate, v.steer_rate, v.roll_angle, v.steer_angle
        Yf, Yr = v.front_side_force, v.rear_side_force
        v.head_torque = v.steering_damping * s
        applied = port_torques(v, m)
        v.front_camber_angle = phi + delta * S
        v.rear_camber_angle = phi
        v.front_slip_angle = delta * c - (v.lateral_velocity + l * r - v.trail * s) / V
        v.rear_slip_angle = -(v.lateral_velocity - v.rear_contact_distance * r) / V
        front_force = v.front_cornering_stiffness * v.front_slip_angle + v.front_camber_stiffness * v.front_camber_angle
        rear_force = v.rear_cornering_stiffness * v.rear_slip_angle + v.rear_camber_stiffness * v.rear_camber_angle
        return {
            "der(lateral_velocity)": applied["lateral_velocity"] + Yf + Yr - (v.front_mass + v.rear_mass) * V * r,
            "der(yaw_rate)": applied["yaw_rate"] + l * Yf - v.rear_contact_distance * Yr
                             - v.front_mass * k * V * r + spin * p + v.front_spin_momentum * S * s,
            "der(roll_rate)": applied["roll_rate"] - roll_moment * (V * r - g * phi)
                              - spin * r - v.front_spin_momentum * c * s + tilt * delta,
            "der(steer_rate)": applied["steer_rate"] - v.trail * Yf
                               - v.front_mass * v.front_mass_offset * V * r
                               - v.front_spin_momentum * (S * r - c * p) + tilt * (phi + S * delta),
            "der(roll_angle)": p,
            "der(steer_angle)": s,
            "der(front_side_force)": relaxed(v, "front", front_force),
            "der(rear_side_force)": relaxed(v, "rear", rear_force),
            **port_motion(v, m),
        }  # fmt: skip


def place_front_frame(v, m):
    """Set the positions of front contact and front mass centre, from the lengths along and across the steer axis."""
    c, S = m.cos(v.caster_angle), m.sin(v.caster_angle)
    reach = v.steer_axis_distance + v.front_mass_offset
    v.front_contact_distance = (v.steer_axis_distance - v.trail) / c
    v.front_mass_distance = reach * c - v.front_mass_rise * S
    v.front_mass_height = reach * S + v.front_mass_rise * c


def symmetric(names, upper):
    """The entries of a symmetric matrix by (row, column) name, from the rows of its upper triangle."""
    entries = {}
    for i, row in enumerate(upper):
        for j, entry in enumerate(row, start=i):
            entries[names[i], names[j]] = entries[names[j], names[i]] = entry
    return entries
