"""The four rigid bodies of a bicycle as parameters: wheels, rear frame with the rigid rider, front frame.

Positions are of the rear contact's frame, x forward, y right, z down. Products of inertia are elements of the tensor,
minus the integral of x z dm. Symbols: Meijaard, Papadopoulos, Ruina, Schwab, Proc. R. Soc. A 463 (2007) 1955-1982,
Table 1.
"""

from fmus import parameter
from vehicle_fmu.steered_vehicle import SteeredVehicle


class BicycleBodies(SteeredVehicle):
    """Base class of bicycles with the parameters of the benchmark."""

    wheelbase = parameter("m", "Wheelbase", symbol="w_b", min=0.05, max=10, start=1.02)
    ground_trail = parameter("m", "Trail, measured on the ground", symbol="c", min=-1, max=2, start=0.08)
    caster_angle = parameter(
        "rad", "Tilt of the steer axis", symbol=r"\epsilon", min=-1.5, max=1.5, start=0.31415926535897931
    )
    rear_wheel_mass = parameter("kg", "Mass of the rear wheel", symbol="m_R", min=0, max=1e3)
    rear_wheel_inertia = parameter(
        "kg.m2", "Inertia of the rear wheel about a diameter", symbol="I_{Rxx}", min=0, max=1e3
    )
    rear_frame_x = parameter(
        "m", "Mass centre of the rear frame ahead of the rear contact", symbol="x_B", min=-10, max=10
    )
    rear_frame_z = parameter("m", "Mass centre of the rear frame, down", symbol="z_B", min=-10, max=10)
    rear_frame_mass = parameter("kg", "Mass of the rear frame with the rigid rider", symbol="m_B", min=0, max=1e5)
    rear_frame_xx = parameter("kg.m2", "Roll inertia of the rear frame", symbol="I_{Bxx}", min=0, max=1e5)
    rear_frame_zz = parameter("kg.m2", "Yaw inertia of the rear frame", symbol="I_{Bzz}", min=0, max=1e5)
    rear_frame_xz = parameter(
        "kg.m2", "Minus the integral of x z dm of the rear frame", symbol="I_{Bxz}", min=-1e5, max=1e5
    )
    front_frame_x = parameter(
        "m", "Mass centre of the front frame ahead of the rear contact", symbol="x_H", min=-10, max=10
    )
    front_frame_z = parameter("m", "Mass centre of the front frame, down", symbol="z_H", min=-10, max=10)
    front_frame_mass = parameter("kg", "Mass of the front frame", symbol="m_H", min=0, max=1e4)
    front_frame_xx = parameter("kg.m2", "Roll inertia of the front frame", symbol="I_{Hxx}", min=0, max=1e4)
    front_frame_zz = parameter("kg.m2", "Yaw inertia of the front frame", symbol="I_{Hzz}", min=0, max=1e4)
    front_frame_xz = parameter(
        "kg.m2", "Minus the integral of x z dm of the front frame", symbol="I_{Hxz}", min=-1e4, max=1e4
    )
    front_wheel_mass = parameter("kg", "Mass of the front wheel", symbol="m_F", min=0, max=1e3)
    front_wheel_inertia = parameter(
        "kg.m2", "Inertia of the front wheel about a diameter", symbol="I_{Fxx}", min=0, max=1e3
    )
