"""The rider in roll: a pelvis that shifts on the saddle, a torso that leans at the waist, a head at the neck.

Heights are above the roll axis (on a motorcycle the ground), y is to the right, phi the frame's roll. With the pelvis
at saddle height h_s shifted by y, torso and head leant by theta, beta relative to the frame, and the absolute rates
u (lateral velocity of the pelvis), W, B of torso and head as states,

    y' = u - v - h_s p,     theta' = W - p,     beta' = B - p
    M [u' W' B'] = [ F_y + m g phi - m a_c
                     T_w - T_n + (m_t c_t + m_h n) (g (phi + theta) - a_c)
                           T_n + m_h c_h (g (phi + beta) - a_c) ]
    F_y = -k_y y - c_y y'      T_w = -k_w theta - c_w theta'      T_n = -k_n (beta - theta) - c_n (beta' - theta')

M follows from the velocities u, u + c_t W, u + n W + c_h B of pelvis, torso and head. v is the lateral velocity of the
frame and v' + a_c its lateral acceleration (a_c is speed times yaw rate; zero on the roll rig); no acceleration is
needed as input. Saddle and waist react on the frame at the roll axis:

    lateral_force F = -F_y - m g phi        roll_torque = -h_s F_y + m g y - T_w
    power into the frame: F v + T_phi p

At the measured points FRF_i = a_i / (alpha h_i), tangential acceleration over that of the same point fixed to the
frame. Gravity in the readings of the accelerometers is not modelled, as in the paper.

Source: Cossalter, Doria, Fabris, Maso, Measurement and identification of the vibration characteristics of
motorcycle riders (2008), Sect. 4, eqs 10 to 12 for the points; the model is this project's.
"""

from fmus import Component, calculated, output, parameter, state
from fmus.interfaces.roll import roll_input, roll_output

POINTS = ("waist", "shoulder", "head")  # 2, 3 and 4 of the paper


class RiderInRoll(Component):
    """Rider in roll: pelvis, torso and head on a rolling frame."""

    saddle_height = parameter("m", "Pelvis above the roll axis", symbol="h_s", min=0, max=3, start=0.8)
    pelvis_mass = parameter("kg", "Mass that shifts with the pelvis", symbol="m_p", min=0.1, max=150, start=9)
    torso_mass = parameter("kg", "Mass of torso and arms", symbol="m_t", min=0.1, max=150, start=35)
    torso_centre = parameter(
        "m", "Mass centre of the torso above the pelvis", symbol="c_t", min=0.01, max=1, start=0.33
    )
    torso_roll_inertia = parameter(
        "kg.m2", "Roll inertia of the torso about its mass centre", symbol="J_t", min=0, max=50, start=1.2
    )
    neck_height = parameter("m", "Neck above the pelvis", symbol="n", min=0.05, max=1.5, start=0.6)
    head_mass = parameter("kg", "Mass of head and helmet", symbol="m_h", min=0.1, max=20, start=6.5)
    head_centre = parameter("m", "Mass centre of the head above the neck", symbol="c_h", min=0.01, max=0.5, start=0.13)
    head_roll_inertia = parameter(
        "kg.m2", "Roll inertia of the head about its mass centre", symbol="J_h", min=0, max=1, start=0.04
    )
    saddle_stiffness = parameter(
        "N/m", "Lateral stiffness between pelvis and frame", symbol="k_y", min=0, max=1e6, start=2000
    )
    saddle_damping = parameter(
        "N.s/m", "Lateral damping between pelvis and frame", symbol="c_y", min=0, max=1e5, start=100
    )
    lean_stiffness = parameter("N.m/rad", "Stiffness of the waist in roll", symbol="k_w", min=0, max=1e6, start=600)
    lean_damping = parameter("N.m.s/rad", "Damping of the waist in roll", symbol="c_w", min=0, max=1e5, start=30)
    neck_roll_stiffness = parameter("N.m/rad", "Stiffness of the neck in roll", symbol="k_n", min=0, max=1e5, start=30)
    neck_roll_damping = parameter("N.m.s/rad", "Damping of the neck in roll", symbol="c_n", min=0, max=1e4, start=0.5)
    waist_point = parameter("m", "Accelerometer at the waist above the pelvis", symbol="z_2", min=-1, max=2, start=0.15)
    shoulder_point = parameter(
        "m", "Accelerometer below the shoulders above the pelvis", symbol="z_3", min=-1, max=2, start=0.45
    )
    head_point = parameter("m", "Accelerometer on the helmet above the neck", symbol="z_4", min=-1, max=1, start=0.2)
    gravity = parameter("m/s2", "Gravitational acceleration", symbol="g", min=0, max=100, start=9.80665)
    rider_mass = calculated(
        "kg", "Mass of the rider, which the rear frame of the vehicle must not include as well", symbol="m"
    )
    rider_height = calculated("m", "Mass centre of the rider above the roll axis", symbol="h_m")
    rider_roll_inertia = calculated("kg.m2", "Roll inertia of the rigid rider about its mass centre", symbol="J_m")

    roll_angle = roll_input("roll_angle")
    roll_rate = roll_input("roll_rate")
    lateral_velocity = roll_input("lateral_velocity")
    turning_acceleration = roll_input("turning_acceleration")
    roll_torque = roll_output("roll_torque")
    lateral_force = roll_output("lateral_force")

    pelvis_shift = state("m", "Shift of the pelvis on the saddle, to the right", symbol="y", exposed=True)
    lean_angle = state("rad", "Lean of the torso relative to the frame", symbol=r"\vartheta", exposed=True)
    head_angle = state("rad", "Lean of the head relative to the frame", symbol=r"\beta", exposed=True)
    pelvis_velocity = state("m/s", "Absolute lateral velocity of the pelvis", symbol="u")
    lean_rate = state("rad/s", "Absolute roll rate of the torso", symbol="W")
    head_rate = state("rad/s", "Absolute roll rate of the head", symbol="B")
    waist_velocity = output("m/s", "Absolute lateral velocity at the waist's accelerometer", symbol="v_2")
    shoulder_velocity = output("m/s", "Absolute lateral velocity at the shoulders' accelerometer", symbol="v_3")
    head_velocity = output("m/s", "Absolute lateral velocity at the helmet's accelerometer", symbol="v_4")

    def mass(self, v, m):
        torso, head = v.torso_mass * v.torso_centre + v.head_mass * v.neck_height, v.head_mass * v.head_centre
        lean = v.torso_roll_inertia + v.torso_mass * v.torso_centre**2 + v.head_mass * v.neck_height**2
        both = head * v.neck_height
        names = ("pelvis_velocity", "lean_rate", "head_rate")
        matrix = (
            (total(v), torso, head),
            (torso, lean, both),
            (head, both, v.head_roll_inertia + head * v.head_centre),
        )
        return {(names[i], names[j]): matrix[i][j] for i in range(3) for j in range(3)}

    def equations(self, v, m):
        shift_rate = v.pelvis_velocity - v.lateral_velocity - v.saddle_height * v.roll_rate
        lean_rate, head_rate = v.lean_rate - v.roll_rate, v.head_rate - v.roll_rate
        saddle = -v.saddle_stiffness * v.pelvis_shift - v.saddle_damping * shift_rate
        waist = -v.lean_stiffness * v.lean_angle - v.lean_damping * lean_rate
        neck = -v.neck_roll_stiffness * (v.head_angle - v.lean_angle) - v.neck_roll_damping * (head_rate - lean_rate)
        weight = total(v) * v.gravity
        torso, head = v.torso_mass * v.torso_centre + v.head_mass * v.neck_height, v.head_mass * v.head_centre
        fall, turn = v.gravity, v.turning_acceleration
        return {
            "der(pelvis_shift)": shift_rate,
            "der(lean_angle)": lean_rate,
            "der(head_angle)": head_rate,
            "der(pelvis_velocity)": saddle + total(v) * (fall * v.roll_angle - turn),
            "der(lean_rate)": waist - neck + torso * (fall * (v.roll_angle + v.lean_angle) - turn),
            "der(head_rate)": neck + head * (fall * (v.roll_angle + v.head_angle) - turn),
            "lateral_force": -saddle - weight * v.roll_angle,
            "roll_torque": -v.saddle_height * saddle + weight * v.pelvis_shift - waist,
            "waist_velocity": v.pelvis_velocity + v.waist_point * v.lean_rate,
            "shoulder_velocity": v.pelvis_velocity + v.shoulder_point * v.lean_rate,
            "head_velocity": v.pelvis_velocity + v.neck_height * v.lean_rate + v.head_point * v.head_rate,
            **rigid_body(v),
        }


def total(v):
    """The rider's mass above the saddle [kg]."""
    return v.pelvis_mass + v.torso_mass + v.head_mass


def point_heights(rider: Component) -> dict[str, float]:
    """Height [m] of each measured point above the roll axis, by name."""
    p = rider.values
    heights = (p["waist_point"], p["shoulder_point"], p["neck_height"] + p["head_point"])
    return {point: p["saddle_height"] + height for point, height in zip(POINTS, heights, strict=True)}


def rigid_body(v):
    """Mass [kg], height of the mass centre [m] and roll inertia about it [kg.m2] of the rigid rider, by name."""
    bodies = (
        (v.pelvis_mass, 0.0, 0.0),
        (v.torso_mass, v.torso_centre, v.torso_roll_inertia),
        (v.head_mass, v.neck_height + v.head_centre, v.head_roll_inertia),
    )
    centre = sum(mass * height for mass, height, _ in bodies) / total(v)
    inertia = sum(J + mass * (height - centre) ** 2 for mass, height, J in bodies)
    return {"rider_mass": total(v), "rider_height": v.saddle_height + centre, "rider_roll_inertia": inertia}
