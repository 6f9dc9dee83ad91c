"""Segments against what the regression must add up to, and the shipped rider against the regression."""

import numpy as np
import pytest

from fmus import InputError
from rider_fmu import riders
from rider_fmu.anthropometry import ASSUMED, full_rider_values, roll_values, segments
from rider_fmu.components.full_rider import FullRider
from rider_fmu.full_rider.reduction import joint_values, reduce


def test_the_trunk_is_the_sum_of_its_parts():
    """de Leva gives the trunk whole and in three parts: the same mass, and the same moments to the regression's
    rounding.
    """
    body = segments(1.741, 73.0)
    parts = [body[f"{part}_trunk"] for part in ("upper", "middle", "lower")]
    trunk = body["trunk"]
    assert sum(p.mass for p in parts) == pytest.approx(trunk.mass, rel=1e-4)
    tops = np.cumsum([0.0, parts[0].length, parts[1].length])
    centre = sum(p.mass * (top + p.centre) for p, top in zip(parts, tops, strict=True)) / trunk.mass
    # The parts start at the suprasternale, 16.4 mm above the middle of the shoulders from which the trunk is measured
    # here.
    assert centre - 0.0164 == pytest.approx(trunk.centre, abs=4e-3)  # the parts are regressed on their own
    assert sum(p.along for p in parts) == pytest.approx(trunk.along, rel=0.03)


def test_a_rider_scales_with_mass_and_height():
    small, tall = segments(1.6, 60.0), segments(1.76, 60.0)
    assert tall["forearm"].length == pytest.approx(1.1 * small["forearm"].length)
    assert tall["trunk"].along == pytest.approx(1.21 * small["trunk"].along)
    assert segments(1.6, 90.0)["hand"].mass == pytest.approx(1.5 * small["hand"].mass)


@pytest.mark.parametrize(
    "height, mass, words",
    [(0.0, 70.0, "height = 0 m"), (1.8, -70.0, "mass = -70 kg"), (3.0, 70.0, r"outside \[1, 2.5\]")],
)
def test_a_body_that_cannot_be_is_refused(height, mass, words):
    with pytest.raises(InputError, match=words):
        segments(height, mass)


def test_the_shipped_riders_are_the_regressions():
    about = riders.contents("full_mean_2011")["about"]
    values = full_rider_values(
        about["height"]["value"], about["mass"]["value"], np.radians(about["torso_inclination"]["value"])
    )
    rider = riders.load("full_mean_2011")
    assert {n: rider.values[n] for n in values} == pytest.approx(values, rel=1e-5)  # six digits in the file
    assert set(ASSUMED) <= set(rider.assumed)
    roll, about = riders.load("roll_3_2008"), riders.contents("roll_3_2008")["about"]
    inertial = roll_values(about["height"]["value"], about["mass"]["value"])
    assert {n: roll.values[n] for n in inertial} == pytest.approx(inertial, rel=1e-4)  # five digits in the file


@pytest.mark.slow
def test_the_shipped_joints_give_the_mean_riders_stiffness_and_damping():
    mean, rider = riders.load("mean_2011"), riders.load("full_mean_2011")
    reduced = reduce(rider)
    for name in ("arm_stiffness", "waist_stiffness", "arm_damping", "waist_damping"):
        assert getattr(reduced, name) == pytest.approx(mean.values[name], rel=1e-7), name  # ten digits in the file
    assert abs(reduced.steer_stiffness) < 1e-6 * reduced.arm_stiffness


@pytest.mark.slow
def test_spreading_has_one_free_direction_and_says_what_it_cannot_meet():
    rider = FullRider("bare", **full_rider_values(1.783, 72.1, np.radians(9.3)))
    mean = riders.load("mean_2011")
    for kind, found in joint_values(rider, mean).items():
        assert found.residual < 1e-9
        assert min(found.joints.values()) > 0
        step = 0.5 * min(v / abs(found.free_direction[j]) for j, v in found.joints.items())
        shifted = {f"{j}_{kind}": v + step * found.free_direction[j] for j, v in found.joints.items()}
        still = {f"{j}_{kind}": v for j, v in found.joints.items()}
        assert reduce(rider.with_values(**shifted)).__dict__ == pytest.approx(
            reduce(rider.with_values(**still)).__dict__, abs=1e-8
        )
    wide = rider.with_values(grip_half_width=0.38, elbow_spread=1.2)
    assert joint_values(wide, mean)["stiffness"].residual > 1e-3
