"""The scenarios on couplings and on exchanging the device."""

import numpy as np
import pytest

from fmus.linear_analysis.linearisation import linearise
from motofmi.scenarios import what_does_a_coupling_do_to_the_modes as coupling_scenario
from motofmi.scenarios import what_if_the_device_is_another as device_scenario
from rider_fmu import riders
from tests.scenarios.test_scenarios import is_complete
from vehicle_fmu import motorcycles, ridden


@pytest.mark.slow
def test_errors_of_the_modes_over_the_step():
    found = coupling_scenario.run()
    held, implicit = (coupling_scenario.worst(found[name][1e-3]) for name in ("jacobi", "implicit_hermite"))
    assert held[1] > 0.03  # every plain master misses a damping ratio by several per cent at a millisecond
    assert implicit[0] < 1e-5 and implicit[1] < 1e-4
    assert is_complete(coupling_scenario.section(found))


@pytest.mark.slow
def test_devices_are_exchanged_on_the_same_wiring(tmp_path):
    found = device_scenario.run(str(tmp_path))
    exact = np.linalg.eigvals(
        linearise(
            ridden(motorcycles.load("reference_2011"), riders.load("mean_2011")),
            **{"vehicle.speed": device_scenario.SPEED},
        ).A
    )
    for value in found["rider"].eigenvalues:
        assert np.abs(exact - value).min() <= 1e-9 * abs(value)
    assert (
        max(found["rider"].eigenvalues.real) > 0 > max(found["damper"].eigenvalues.real)
    )  # 2011: the rider's weave grows at 50 m/s
    assert set(found["rider and damper"].shares) == {"vehicle", "rider_mean_2011"}  # a damper has no state of its own
    assert sum(found["rider and damper"].shares.values()) == pytest.approx(
        np.ones(len(found["rider and damper"].eigenvalues))
    )
    # Two devices: the motion of the handlebar is an input of each, and both torques act.
    run = found["rider and damper"].run
    assert run["damper_7_5.handlebar_torque"] == pytest.approx(-7.5 * run["vehicle.steer_rate"], rel=1e-12)
    assert is_complete(device_scenario.section(found))
