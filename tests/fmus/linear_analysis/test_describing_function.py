"""The linearisation of a component at a finite amplitude, compared with describing functions."""

import numpy as np
import pytest

from fmus.linear_analysis.describing_function import change_by_motion
from fmus.linear_analysis.linearisation import linearise
from fmus.support.errors import InputError
from rider_fmu import riders
from rider_fmu.effects.arms import HardeningArms
from rider_fmu.effects.head import SteerDamping, SteeringFriction
from vehicle_fmu import motorcycles, ridden

AMPLITUDE, OMEGA, FRICTION = 0.03, 25.0, 0.7  # rad, rad/s, N.m
PHASE = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
SINE = {"vehicle.steer_angle": AMPLITUDE * np.sin(PHASE), "vehicle.steer_rate": AMPLITUDE * OMEGA * np.cos(PHASE)}
SPEEDS = {"vehicle.speed": np.array([10.0, 30.0])}


def ridden_by(effect, **values):
    rider = (
        riders.load("mean_2011")
        .with_effects(effect)
        .with_values(**{f"{effect.family}.{n}": value for n, value in values.items()})
    )
    return ridden(motorcycles.load("sharp_1971"), rider)


def in_motion_of(system, motion):
    """The matrix A of the system linearised about a motion, at each speed."""
    return linearise(system, **SPEEDS).A + change_by_motion(system, motion, **SPEEDS)


def damping_added(system, motion):
    """The steer damping [N.m.s/rad] that slows the steer as the system's effect does in the given motion, at each
    speed."""
    row = system.states.index("vehicle.steer_rate")
    in_motion, plain = (
        in_motion_of(system, motion),
        linearise(ridden(motorcycles.load("sharp_1971"), riders.load("mean_2011")), **SPEEDS).A,
    )
    damped = linearise(ridden_by(SteerDamping(), damping=1.0), **SPEEDS)
    return (in_motion - plain)[:, row, row] / (damped.A - plain)[:, row, row]


@pytest.mark.slow
def test_dry_friction_under_a_sine_is_the_damper_of_its_describing_function():
    system = ridden_by(SteeringFriction(), friction_torque=FRICTION)
    # Smoothed over a small share of the rate's amplitude.
    assert damping_added(system, SINE) == pytest.approx(4 * FRICTION / (np.pi * AMPLITUDE * OMEGA), rel=2e-3)


@pytest.mark.slow
def test_dry_friction_under_gaussian_motion_is_the_damper_of_statistical_linearisation():
    system, deviation = ridden_by(SteeringFriction(), friction_torque=FRICTION), 0.8
    rate = deviation * np.random.default_rng(1).standard_normal(200_000)
    assert damping_added(system, {"vehicle.steer_rate": rate}) == pytest.approx(
        FRICTION * np.sqrt(2 / np.pi) / deviation, rel=5e-3
    )


def stiffened(motion, deflection):
    """Two Jacobians, columns of the states in `motion`: of a rider with a cubic spring, by the describing function, and
    of a rider at rest whose spring is stiffer by 3/4 of the cubic stiffness times the squared deflection.
    """
    cubic, rider = 2e4, riders.load("mean_2011")  # N.m/rad3
    stiffer = rider.with_values(arm_stiffness=rider.start_values()["arm_stiffness"] + 0.75 * cubic * deflection**2)
    system = ridden_by(HardeningArms(), cubic_stiffness=cubic)
    columns = [system.states.index(n) for n in motion]
    in_motion, expected = (
        in_motion_of(system, motion),
        linearise(ridden(motorcycles.load("sharp_1971"), stiffer), **SPEEDS).A,
    )
    return in_motion[..., columns], expected[..., columns]


@pytest.mark.slow
def test_a_cubic_spring_under_a_sine_stiffens_by_three_quarters_of_its_square():
    np.testing.assert_allclose(*stiffened(SINE, AMPLITUDE), rtol=1e-9, atol=1e-6)


@pytest.mark.slow
def test_what_is_linear_stays_what_it_is():
    system = ridden_by(SteerDamping(), damping=3.0)
    np.testing.assert_allclose(
        in_motion_of(system, SINE), linearise(system, **SPEEDS).A, rtol=1e-9, atol=1e-6
    )


def test_what_the_motion_of_a_rider_adds_is_the_same_at_all_speeds():
    system = ridden_by(SteeringFriction(), friction_torque=FRICTION)
    slow, fast = change_by_motion(system, SINE, **SPEEDS)
    np.testing.assert_allclose(fast, slow, rtol=1e-9, atol=1e-9 * np.abs(slow).max())  # rounding of the tyres' terms


@pytest.mark.slow
def test_states_that_move_in_proportion_share_what_motion_adds():
    """The torso turns by twice the steer angle, against it: which of them stiffens the spring is not identifiable, but
    together they do as they must.
    """
    steer = SINE["vehicle.steer_angle"]
    in_motion, expected = stiffened({"vehicle.steer_angle": steer, "device.torso_angle": -2 * steer}, 3 * AMPLITUDE)
    together = np.array([1.0, -2.0])
    np.testing.assert_allclose(in_motion @ together, expected @ together, rtol=1e-9, atol=1e-6)


def test_a_name_that_is_no_state_is_an_error():
    with pytest.raises(InputError, match=r"vehicle.steer_angl.*did you mean"):
        change_by_motion(ridden_by(SteerDamping(), damping=1.0), {"vehicle.steer_angl": PHASE})
