"""The bicycle on tyres against Sharp's equations for the same bodies, and in the limit of wheels that roll without slip."""

import numpy as np
import pytest

from fmus import linearise
from tests.vehicle_fmu.test_motorcycle import motorcycle_like
from vehicle_fmu import modes, motorcycles, over_speed, ridden

BICYCLE = motorcycles.load("benchmark_bicycle_on_tyres", added_steer_inertia=0.05, steering_damping=0.3)
TYRES = ("front_cornering_coefficient", "rear_cornering_coefficient", "front_camber_coefficient",
         "rear_camber_coefficient", "front_relaxation_length", "rear_relaxation_length")  # fmt: skip


def sharps(bicycle):
    """Sharp's motorcycle of 1971 with the bodies and tyres of the bicycle."""
    v = bicycle.values
    whole = motorcycle_like(bicycle, 0.0)
    weight = v["gravity"] * sum(v[f"{n}_mass"] for n in ("rear_wheel", "rear_frame", "front_frame", "front_wheel"))
    load = {"front": -whole.values["front_tyre_load"], "rear": weight + whole.values["front_tyre_load"]}
    return whole.with_values(**{f"{end}_{kind}_stiffness": load[end] * v[f"{end}_{kind}_coefficient"]
                                for end in load for kind in ("cornering", "camber")},
                             **{f"{end}_relaxation_length": v[f"{end}_relaxation_length"] for end in load})  # fmt: skip


@pytest.mark.parametrize("speed", np.linspace(0.5, 20.0, 20))
def test_eigenvalues_are_those_of_sharps_equations(speed):
    ours, theirs = (np.linalg.eigvals(linearise(each, speed=speed).A) for each in (BICYCLE, sharps(BICYCLE)))
    # Two derivations of one model: the rounding of two eigensolutions.
    assert np.sort_complex(ours) == pytest.approx(np.sort_complex(theirs), rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("torque", ["handlebar_torque", "frame_torque", "steer_torque", "roll_torque"])
def test_responses_to_torques_are_those_of_sharps_equations(torque):
    omega = np.array([0.5, 3.0, 10.0, 60.0])  # rad/s
    for output in ("steer_angle", "roll_angle", "frame_rate", "turning_acceleration", "rear_side_force"):
        ours, theirs = (linearise(each, speed=6.0).frequency_response(omega, output, torque)
                        for each in (BICYCLE, sharps(BICYCLE)))  # fmt: skip
        assert ours == pytest.approx(theirs, rel=1e-8)


@pytest.mark.parametrize("speed", [1.0, 5.0, 10.0])
def test_without_slip_it_is_the_bicycle_of_the_benchmark(speed):
    wanted = np.linalg.eigvals(linearise(motorcycles.load("benchmark_bicycle"), speed=speed).A)
    errors = []
    for coefficient in (1e3, 1e4, 1e5):
        tyres = dict.fromkeys(TYRES[:2], coefficient) | dict.fromkeys(TYRES[4:], 1e-6)
        stiff = motorcycles.load("benchmark_bicycle_on_tyres", **tyres)
        found = np.linalg.eigvals(linearise(stiff, speed=speed).A)
        errors.append(max(np.abs(found - w).min() for w in wanted))
    # The error falls as 1/C; terms in 1/C^2 are below 2 % of it from 1e3 on.
    assert np.divide(errors[1:], errors[:-1]) == pytest.approx(0.1, rel=0.02)


def test_relaxation_makes_wobble_less_stable():
    """Sharp 1971: without relaxation the wobble is well damped at all speeds."""
    speeds = np.array([4.0, 8.0, 12.0])
    damping = [modes(over_speed(ridden(motorcycles.load("benchmark_bicycle_on_tyres", **dict.fromkeys(TYRES[4:], length)))),
                     speeds)["wobble"].eigenvalue.real for length in (0.1, 0.25)]  # fmt: skip
    assert (damping[0] < damping[1]).all() and (damping[1] < 0).all()
