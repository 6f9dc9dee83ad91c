"""A rider on a rolling mock-up: pelvis, trunk and head slide sideways against each other, as masses in a chain.

    m_2 a_2 = -k_s u_2 - c_s u_2' + k_w (u_3 - u_2) + c_w (u_3' - u_2')
    m_3 a_3 = -k_w (u_3 - u_2) - c_w (u_3' - u_2') - k_a u_3 - c_a u_3' + k_n (u_4 - u_3) + c_n (u_4' - u_3')
    m_4 a_4 = -k_n (u_4 - u_3) - c_n (u_4' - u_3'),      a_i = h_i alpha + u_i''

u_i is the tangential displacement relative to the mock-up of waist (2), shoulders (3) and head (4), h_i their
distance from the roll axis, alpha the roll acceleration. The saddle holds the pelvis, the arms hold the trunk
to the mock-up. Gravity is neglected, as in the steer test.

The test is that of Cossalter, Doria, Fabris, Maso (2008), Sect. 4. The paper prints no model for it: this chain
and its values are assumed, chosen for the features that the paper prints. It meets all but the head's second
peak, which the paper itself suspects to be voluntary.
"""

from fmus import Component, input, local, output, parameter
from fmus.variables import state


class RollRider(Component):
    """Rider isolated from the mock-up's roll, with the accelerometers at mock-up, waist, shoulders and head."""

    pelvis_mass = parameter("kg", "Mass that moves with the waist", symbol="m_2", min=0.1, max=200, start=25.0)
    trunk_mass = parameter("kg", "Mass that moves with the shoulders", symbol="m_3", min=0.1, max=200, start=35.0)
    head_mass = parameter("kg", "Mass of head and helmet", symbol="m_4", min=0.1, max=50, start=6.0)
    mockup_height = parameter("m", "Distance of the mock-up's accelerometer from the roll axis", symbol="h_1", min=0.01, max=5, start=0.5)
    waist_height = parameter("m", "Distance of the waist from the roll axis", symbol="h_2", min=0.01, max=5, start=0.9)
    shoulder_height = parameter("m", "Distance of the shoulders from the roll axis", symbol="h_3", min=0.01, max=5, start=1.3)
    head_height = parameter("m", "Distance of the head from the roll axis", symbol="h_4", min=0.01, max=5, start=1.65)
    saddle_stiffness = parameter("N/m", "Stiffness of the saddle", symbol="k_s", min=0, max=1e6, start=2000.0)
    saddle_damping = parameter("N.s/m", "Damping of the saddle", symbol="c_s", min=0, max=1e5, start=370.0)
    bending_stiffness = parameter("N/m", "Stiffness of the waist", symbol="k_w", min=0, max=1e6, start=4200.0)
    bending_damping = parameter("N.s/m", "Damping of the waist", symbol="c_w", min=0, max=1e5, start=575.0)
    holding_stiffness = parameter("N/m", "Stiffness of the arms", symbol="k_a", min=0, max=1e6, start=4.0)
    holding_damping = parameter("N.s/m", "Damping of the arms", symbol="c_a", min=0, max=1e5, start=9.0)
    neck_stiffness = parameter("N/m", "Stiffness of the neck", symbol="k_n", min=0, max=1e6, start=28.0)
    neck_damping = parameter("N.s/m", "Damping of the neck", symbol="c_n", min=0, max=1e5, start=27.0)

    roll_acceleration = input("rad/s2", "Roll acceleration of the mock-up", symbol=r"\alpha")
    waist_shift = state("m", "Tangential displacement of the waist relative to the mock-up", symbol="u_2")
    shoulder_shift = state("m", "Tangential displacement of the shoulders relative to the mock-up", symbol="u_3")
    head_shift = state("m", "Tangential displacement of the head relative to the mock-up", symbol="u_4")
    waist_speed = state("m/s", "Tangential speed of the waist relative to the mock-up")
    shoulder_speed = state("m/s", "Tangential speed of the shoulders relative to the mock-up")
    head_speed = state("m/s", "Tangential speed of the head relative to the mock-up")
    saddle_force = local("N", "Force of the saddle on the pelvis")
    bending_force = local("N", "Force of the trunk on the pelvis")
    holding_force = local("N", "Force of the arms on the trunk")
    neck_force = local("N", "Force of the head on the trunk")
    mockup_acceleration = output("m/s2", "Tangential acceleration of the mock-up", symbol="a_1")
    waist_acceleration = output("m/s2", "Tangential acceleration of the waist", symbol="a_2")
    shoulder_acceleration = output("m/s2", "Tangential acceleration of the shoulders", symbol="a_3")
    head_acceleration = output("m/s2", "Tangential acceleration of the head", symbol="a_4")

    def equations(self, v, m):
        v.saddle_force = -v.saddle_stiffness * v.waist_shift - v.saddle_damping * v.waist_speed
        v.bending_force = (v.bending_stiffness * (v.shoulder_shift - v.waist_shift)
                           + v.bending_damping * (v.shoulder_speed - v.waist_speed))  # fmt: skip
        v.holding_force = -v.holding_stiffness * v.shoulder_shift - v.holding_damping * v.shoulder_speed
        v.neck_force = v.neck_stiffness * (v.head_shift - v.shoulder_shift) + v.neck_damping * (v.head_speed - v.shoulder_speed)
        waist = (v.saddle_force + v.bending_force) / v.pelvis_mass
        shoulder = (v.holding_force + v.neck_force - v.bending_force) / v.trunk_mass
        head = -v.neck_force / v.head_mass
        return {
            "der(waist_shift)": v.waist_speed,
            "der(shoulder_shift)": v.shoulder_speed,
            "der(head_shift)": v.head_speed,
            "der(waist_speed)": waist - v.waist_height * v.roll_acceleration,
            "der(shoulder_speed)": shoulder - v.shoulder_height * v.roll_acceleration,
            "der(head_speed)": head - v.head_height * v.roll_acceleration,
            "mockup_acceleration": v.mockup_height * v.roll_acceleration,
            "waist_acceleration": waist,
            "shoulder_acceleration": shoulder,
            "head_acceleration": head,
        }
