"""The motorcycle against Sharp's printed eigenvalues, a second derivation, and the bicycle as its tyres get stiff."""

from math import cos, sin

import numpy as np
import pytest

from fmus import linearise
from fmus.support.published import last_digit, table
from tests.truth import motorcycle_by_kane
from vehicle_fmu import Motorcycle, modes, motorcycles, over_speed, ridden
from vehicle_fmu.published import SHARP_1971_EIGENVALUES

FOOT = 0.3048  # m


def printed_by_sharp():
    for row in table(SHARP_1971_EIGENVALUES):
        for column, text in row.items():
            if column != "speed_ft_per_s":
                yield pytest.param(float(row["speed_ft_per_s"]) * FOOT, *column.partition("_")[::2], text,
                                   id=f"{row['speed_ft_per_s']} ft/s {column}")  # fmt: skip


@pytest.mark.parametrize("speed, mode, part, printed", list(printed_by_sharp()))
def test_eigenvalues_are_those_that_sharp_printed(speed, mode, part, printed):
    found = modes(over_speed(ridden(motorcycles.load("sharp_1971"))), [speed])[mode].eigenvalue[0]
    value = found.imag if part == "imag" else found.real
    # One unit of the last digit: the printed value is rounded, and so are the imperial parameters.
    assert value == pytest.approx(float(printed), abs=last_digit(printed))


# A second derivation ------------------------------------------------------------------------------

KANE_NAMES = {
    "M_f": "front_mass", "M_r": "rear_mass", "Z_f": "front_tyre_load", "I_rx": "rear_roll_inertia", "I_rz": "rear_yaw_inertia",
    "C_rxz": "rear_product_of_inertia", "I_fx": "front_cross_inertia", "I_fz": "front_steer_inertia",
    "I_fxz": "front_product_of_inertia", "i_fy": "front_spin_inertia", "i_ry": "rear_spin_inertia", "R_f": "front_wheel_radius",
    "R_r": "rear_wheel_radius", "a": "steer_axis_distance", "b": "rear_contact_distance", "e": "front_mass_offset",
    "f": "front_mass_rise", "h": "rear_mass_height", "t": "trail", "eps": "caster_angle", "C_f1": "front_cornering_stiffness",
    "C_f2": "front_camber_stiffness", "C_r1": "rear_cornering_stiffness", "C_r2": "rear_camber_stiffness",
    "sigma_f": "front_relaxation_length", "sigma_r": "rear_relaxation_length", "K": "steering_damping", "g": "gravity",
}  # fmt: skip
KANE_SIGNALS = {
    "v": "lateral_velocity", "r": "yaw_rate", "p": "roll_rate", "s": "steer_rate", "phi": "roll_angle", "delta": "steer_angle",
    "Y_f": "front_side_force", "Y_r": "rear_side_force", "T_h": "handlebar_torque", "T_f": "frame_torque", "T_d": "steer_torque",
    "T_phi": "roll_torque", "F": "lateral_force",
}  # fmt: skip


@pytest.fixture(scope="module")
def kane():
    return motorcycle_by_kane.derive()


def random_motorcycle(generator):
    """Sharp's motorcycle with every parameter changed by up to a half, and the product of inertia that it lacks."""
    values = {n: x * generator.uniform(0.5, 1.5) for n, x in motorcycles.load("sharp_1971").values.items()}
    values["front_product_of_inertia"] = generator.uniform(-0.1, 0.1)
    values["added_steer_inertia"] = generator.uniform(0, 0.2)
    return Motorcycle(**values)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100))
def test_kanes_equations_give_the_same_matrices(kane, seed):
    generator = np.random.default_rng(seed)
    motorcycle, speed = random_motorcycle(generator), generator.uniform(1, 80)
    values = dict(motorcycle.values)
    values["front_steer_inertia"] += values["added_steer_inertia"]
    arguments = [speed if str(p) == "V" else values[KANE_NAMES[str(p)]] for p in motorcycle_by_kane.PARAMETERS]
    mass, slopes = (matrix(*arguments) for matrix in kane)
    expected = np.linalg.solve(mass, slopes)
    space = linearise(motorcycle, speed=speed)
    assert set(space.states) | set(space.inputs) == {*KANE_SIGNALS.values(), "speed"}
    states = [space.states.index(KANE_SIGNALS[n]) for n in motorcycle_by_kane.STATES]
    inputs = [space.inputs.index(KANE_SIGNALS[n]) for n in motorcycle_by_kane.INPUTS]
    computed = np.hstack([space.A[np.ix_(states, states)], space.B[np.ix_(states, inputs)]])
    # Against the largest entry of each row, whose terms cancel to rounding where an entry is small.
    scale = np.abs(expected).max(axis=1, keepdims=True)
    assert (np.abs(computed - expected) <= 1e-9 * scale).all()


# The bicycle as the limit of stiff tyres ----------------------------------------------------------


def motorcycle_like(bicycle, cornering_stiffness):
    """The motorcycle with the bicycle's bodies and tyres that do nothing but resist slip.

    The bicycle's positions are from the rear contact, the motorcycle's from below its rear mass centre; Sharp's
    product of inertia is the integral of x z dm, the bicycle's is minus it.
    """
    p = bicycle.values
    S, c = sin(p["caster_angle"]), cos(p["caster_angle"])
    rear = assembly([(p["rear_frame_mass"], p["rear_frame_x"], p["rear_frame_z"], p["rear_frame_xx"], p["rear_frame_zz"], p["rear_frame_xz"]),
                     (p["rear_wheel_mass"], 0.0, -p["rear_wheel_radius"], p["rear_wheel_inertia"], p["rear_wheel_inertia"], 0.0)])  # fmt: skip
    front = assembly([(p["front_frame_mass"], p["front_frame_x"], p["front_frame_z"], p["front_frame_xx"], p["front_frame_zz"], p["front_frame_xz"]),
                      (p["front_wheel_mass"], p["wheelbase"], -p["front_wheel_radius"], p["front_wheel_inertia"], p["front_wheel_inertia"], 0.0)])  # fmt: skip
    (Mr, xr, zr, rxx, rzz, rxz), (Mf, xf, zf, fxx, fzz, fxz) = rear, front
    return Motorcycle(
        front_mass=Mf, rear_mass=Mr, front_tyre_load=-p["gravity"] * (Mr * xr + Mf * xf) / p["wheelbase"],
        rear_roll_inertia=rxx, rear_yaw_inertia=rzz, rear_product_of_inertia=-rxz,
        front_cross_inertia=fxx * c**2 + fzz * S**2 - 2 * fxz * S * c,
        front_steer_inertia=fxx * S**2 + fzz * c**2 + 2 * fxz * S * c,
        front_product_of_inertia=(fxx - fzz) * S * c + fxz * (c**2 - S**2),
        added_steer_inertia=p["added_steer_inertia"], front_spin_inertia=p["front_spin_inertia"], rear_spin_inertia=p["rear_spin_inertia"],
        front_wheel_radius=p["front_wheel_radius"], rear_wheel_radius=p["rear_wheel_radius"],
        steer_axis_distance=(p["wheelbase"] + p["ground_trail"] - xr) * c, rear_contact_distance=xr,
        front_mass_offset=(xf - p["wheelbase"] - p["ground_trail"]) * c - zf * S, front_mass_rise=-((xf - xr) * S + zf * c),
        rear_mass_height=-zr, trail=p["ground_trail"] * c, caster_angle=p["caster_angle"], gravity=p["gravity"],
        front_cornering_stiffness=cornering_stiffness, rear_cornering_stiffness=cornering_stiffness,
        front_relaxation_length=1e-6, rear_relaxation_length=1e-6, steering_damping=p["steering_damping"],
    )  # fmt: skip


def assembly(bodies):
    """(mass, x, z, I_xx, I_zz, I_xz) of rigid bodies in one, about their common mass centre;

    I_xz = - integral of x z dm.
    """
    mass, xs, zs, xx, zz, xz = (np.array(column) for column in zip(*bodies, strict=True))
    x, z = xs @ mass / mass.sum(), zs @ mass / mass.sum()
    return (
        mass.sum(),
        x,
        z,
        (xx + mass * (zs - z) ** 2).sum(),
        (zz + mass * (xs - x) ** 2).sum(),
        (xz - mass * (xs - x) * (zs - z)).sum(),
    )


STIFFNESSES = (1e6, 1e7, 1e8)  # N/rad


def error_of_eigenvalues(bicycle, stiffness, speed):
    wanted = np.linalg.eigvals(linearise(bicycle, speed=speed).A)
    found = np.linalg.eigvals(linearise(motorcycle_like(bicycle, stiffness), speed=speed).A)
    return max(np.abs(found - w).min() for w in wanted)


@pytest.mark.parametrize("speed", [1.0, 2.0, 5.0, 8.0, 10.0])
def test_stiff_tyres_give_the_bicycle(speed):
    bicycle = motorcycles.load("benchmark_bicycle")
    errors = np.array([error_of_eigenvalues(bicycle, stiffness, speed) for stiffness in STIFFNESSES])
    assert error_of_eigenvalues(bicycle, 1e9, speed) < 1e-4  # 1/s
    # The error falls as 1/C: a tenth for ten times the stiffness, with terms in 1/C^2 far below these bounds, and a
    # rounding error of up to 1e-6 1/s.
    assert errors[1:] == pytest.approx(0.1 * errors[:-1], rel=0.02, abs=1e-6)


def test_the_limit_needs_the_front_product_of_inertia():
    bicycle = motorcycles.load("benchmark_bicycle")
    without = motorcycle_like(bicycle, 1e9).with_values(front_product_of_inertia=0)
    found = np.linalg.eigvals(linearise(without, speed=5.0).A)
    assert np.abs(found - (-0.77534188 + 4.46486771j)).min() > 0.01


@pytest.mark.parametrize("torque", ["handlebar_torque", "frame_torque", "steer_torque", "roll_torque"])
@pytest.mark.parametrize("answer", ["steer_angle", "steer_rate", "roll_angle", "frame_rate"])
def test_stiff_tyres_give_the_bicycles_responses_to_torques(torque, answer):
    bicycle = motorcycles.load("benchmark_bicycle", added_steer_inertia=0.05, steering_damping=2.0)
    omega = np.array([0.5, 3.0, 10.0, 40.0])  # rad/s
    wanted = linearise(bicycle, speed=6.0).frequency_response(omega, answer, torque)
    found = linearise(motorcycle_like(bicycle, 1e8), speed=6.0).frequency_response(omega, answer, torque)
    assert found == pytest.approx(wanted, rel=1e-3)  # the eigenvalues' error of 1e-4 and less, at 1e8 N/rad


def test_the_front_tyre_load_balances_the_masses():
    motorcycle = motorcycles.load("sharp_1971")
    p = motorcycle.values
    S, c = sin(p["caster_angle"]), cos(p["caster_angle"])
    front = (p["steer_axis_distance"] + p["front_mass_offset"]) * c - p["front_mass_rise"] * S
    wheelbase = p["rear_contact_distance"] + (p["steer_axis_distance"] - p["trail"]) / c
    load = (
        p["gravity"]
        * (p["rear_mass"] * p["rear_contact_distance"] + p["front_mass"] * (p["rear_contact_distance"] + front))
        / wheelbase
    )
    assert p["front_tyre_load"] == pytest.approx(
        -load, rel=0.002
    )  # Sharp's -226 lbf are rounded, the masses give -226.3
