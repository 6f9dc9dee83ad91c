"""The rider in roll: the published features, energy, the rigid limit on a motorcycle, and the test in time."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus import InputError, linearise
from rider_fmu import RiderInRoll, riders
from rider_fmu.anthropometry import roll_values
from rider_fmu.components.rider_in_roll import POINTS, point_heights
from rider_fmu.roll_features import FEATURES, FREQUENCIES, RIDERS, misses, readings, roll_frf
from vehicle_fmu import motorcycles, ridden
from vehicle_fmu.rider_mass_removed import without_rider_mass

RIDER = riders.load("roll_3_2008")
JOINTS = [f"{joint}_{kind}" for joint in ("saddle", "lean", "neck_roll") for kind in ("stiffness", "damping")]


@pytest.mark.parametrize("number", RIDERS)
def test_every_feature_that_is_printed_of_a_rider_is_met_at_once(number):
    curves = roll_frf(riders.load(f"roll_{number}_2008"))
    rows = zip(FEATURES, readings(curves), misses(curves), strict=True)
    assert not [(f.point, f.name, read) for f, read, miss in rows if miss and number in f.riders]


def test_the_head_of_rider_2_does_not_come_to_rest():
    """2008, Sect. 4.1: his amplitude at high frequency does not decrease very sharply, that of riders 1 and 3 to
    below 0.1.
    """
    high = {k: np.abs(roll_frf(riders.load(f"roll_{k}_2008"))["head"])[FREQUENCIES > 4].min() for k in RIDERS}
    assert high[2] > 0.1 > max(high[1], high[3])


def test_a_rider_without_joints_misses_features():
    rigid = RIDER.with_values(**{joint: 50 * RIDER.values[joint] for joint in JOINTS})
    assert (misses(roll_frf(rigid)) > 0).sum() > 5


def test_held_stiff_every_point_follows_the_frame():
    stiff = RIDER.with_values(saddle_stiffness=1e6, lean_stiffness=1e6, neck_roll_stiffness=1e5)
    low = roll_frf(stiff, np.array([0.01, 0.1]))
    for point in POINTS:
        # 500 N per 10 mm of saddle: the static deflection in roll is below 0.2 % of h phi.
        assert np.abs(low[point] - 1).max() < 2e-3


@pytest.mark.slow
def test_the_port_gives_back_what_it_took():
    """Without dampers, kinetic energy plus springs less weights' falls is the power of the port, integrated."""
    rider = RIDER.with_values(**{joint: 0.0 for joint in JOINTS if joint.endswith("damping")})
    p = rider.values

    def frame(t):
        """Roll angle, its rate, lateral velocity; no turning."""
        return 0.1 * np.sin(5 * t), 0.5 * np.cos(5 * t), 0.4 * np.sin(8 * t), 0.0

    def slope(t, x):
        rates, outputs = rider.derivatives(x[:6], np.array(frame(t)), t)
        answered = dict(zip(rider.outputs, outputs, strict=True))
        return [*rates, answered["lateral_force"] * frame(t)[2] + answered["roll_torque"] * frame(t)[1]]

    def energy(t, x):
        y, lean, head, u, W, B = x[:6]
        phi, g = frame(t)[0], p["gravity"]
        speeds = ((p["pelvis_mass"], u), (p["torso_mass"], u + p["torso_centre"] * W), (p["head_mass"], u + p["neck_height"] * W + p["head_centre"] * B),
                  (p["torso_roll_inertia"], W), (p["head_roll_inertia"], B))  # fmt: skip
        springs = (
            p["saddle_stiffness"] * y**2 + p["lean_stiffness"] * lean**2 + p["neck_roll_stiffness"] * (head - lean) ** 2
        )
        # Heights to second order in the angles.
        mass = p["pelvis_mass"] + p["torso_mass"] + p["head_mass"]
        fall = mass * (y * phi + p["saddle_height"] * phi**2 / 2)
        fall += (p["torso_mass"] * p["torso_centre"] + p["head_mass"] * p["neck_height"]) * (phi + lean) ** 2 / 2
        fall += p["head_mass"] * p["head_centre"] * (phi + head) ** 2 / 2
        return sum(m * v**2 for m, v in speeds) / 2 + springs / 2 - g * fall

    solution = solve_ivp(slope, (0, 2), np.zeros(7), method="DOP853", rtol=1e-10, atol=1e-12)
    balance = [energy(t, x) + x[6] for t, x in zip(solution.t, solution.y.T, strict=True)]
    assert np.ptp(balance) < 1e-7 * np.abs(solution.y[6]).max()  # of the integration


@pytest.mark.slow
@pytest.mark.parametrize("speed", [5.0, 20.0, 45.0])
def test_a_rigid_rider_on_a_motorcycle_without_his_mass_is_the_motorcycle(speed):
    """Weights, turning and reactions of the port are right: the eigenvalues return, the error falling as 1 /
    stiffness.
    """
    whole = motorcycles.load("sharp_1971")
    wanted = np.linalg.eigvals(linearise(whole, speed=speed).A)
    rider = riders.load("roll_1971")
    errors = []
    for k in (1e5, 1e6):
        stiff = rider.with_values(saddle_stiffness=k, lean_stiffness=k, neck_roll_stiffness=k / 10,
                                  saddle_damping=k / 10, lean_damping=k / 10, neck_roll_damping=k / 100)  # fmt: skip
        found = np.linalg.eigvals(linearise(ridden(whole, stiff), **{"vehicle.speed": speed}).A)
        errors.append(max(np.abs(found - w).min() / max(abs(w), 1.0) for w in wanted))
    assert errors[1] < 1e-2
    assert errors[1] < errors[0] / 5


@pytest.mark.slow
def test_the_features_come_out_of_a_test_in_time():
    """A sine of 1 deg imposed on the component; accelerations by the phasor of the velocities."""
    expected = roll_frf(RIDER)
    heights = point_heights(RIDER)
    frequency = 1.5
    omega = 2 * np.pi * frequency
    times = 24.0 + np.arange(64) / 64 / frequency
    solution = solve_ivp(
        lambda t, x: RIDER.derivatives(x, frame_inputs(t, omega))[0],
        (0, times[-1]),
        np.zeros(6),
        rtol=1e-7,
        atol=1e-9,
        t_eval=times,
    )
    outputs = np.array([RIDER.derivatives(x, frame_inputs(t, omega))[1] for t, x in zip(times, solution.y.T, strict=True)])
    for point in POINTS:
        velocity = np.exp(-1j * omega * times) @ outputs[:, RIDER.outputs.index(f"{point}_velocity")] * 2 / 64
        found = 1j * omega * velocity / (1j * omega**2 * np.radians(1) * heights[point])
        # The slowest mode of this rider decays by exp(-0.2 * 24 s).
        assert found == pytest.approx(expected[point][FREQUENCIES == frequency][0], abs=5e-3)


def frame_inputs(t, omega):
    return np.array([np.radians(1) * np.sin(omega * t), np.radians(1) * omega * np.cos(omega * t), 0.0, 0.0])


def test_what_a_motorcycle_cannot_spare_is_refused():
    whole = motorcycles.load("sharp_1971")
    with pytest.raises(InputError, match="does not contain 300 kg"):
        without_rider_mass(whole, 300.0, 0.5, 1.0)
    with pytest.raises(InputError, match="rear_roll_inertia would be"):
        without_rider_mass(whole, 60.0, 1.5, 5.0)


def test_negative_masses_are_refused():
    with pytest.raises(InputError, match="head_mass = -1 kg is outside its bounds"):
        RiderInRoll("bad", head_mass=-1.0)


def test_the_rider_on_the_motorcycle_is_of_his_height_and_mass():
    shipped = riders.load("roll_1971").values
    for name, value in roll_values(1.76, 72.0).items():
        assert shipped[name] == pytest.approx(value, rel=1e-5), name  # six digits in the file
