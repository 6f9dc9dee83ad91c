"""The full rider against the same six bodies in Exudyn, whose solver closes the loops by constraints."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from motofmi.scenarios.hosts.exudyn_full_rider import response
from rider_fmu import riders
from rider_fmu.components.full_rider import on_rig

pytest.importorskip("exudyn", reason="Exudyn is not installed (the extra `hosts`)")
AMPLITUDE, FREQUENCY, DURATION = 27.0, 3.0, 0.6  # N.m, Hz, s: some 10 deg of steer


def test_ten_degrees_at_three_hertz_agree_within_exudyns_own_step_error():
    rig = on_rig(riders.load("full_mean_2011"))
    coarse, fine = (response(rig, AMPLITUDE, FREQUENCY, step, DURATION) for step in (2e-3, 1e-3))
    times = coarse[:, 0]

    def slope(t, x):
        torque = np.zeros(len(rig.inputs))
        torque[rig.inputs.index("servo_torque")] = AMPLITUDE * np.sin(2 * np.pi * FREQUENCY * t)
        return rig.derivatives(x, torque)[0]

    own = (
        solve_ivp(slope, (0, DURATION + 1e-9), np.zeros(4), method="DOP853", rtol=1e-9, atol=1e-11, t_eval=times)
        .y[:2]
        .T
    )
    assert np.radians(8) < np.abs(own[:, 0]).max() < np.radians(14)
    step_error = np.abs(fine[::2, 1:] - coarse[:, 1:]).max()
    assert np.abs(coarse[:, 1:] - own).max() < 1.5 * step_error  # second order: 4/3 of the difference
    extrapolated = (4 * fine[::2, 1:] - coarse[:, 1:]) / 3
    # What is left after the step's error of second order is taken out is of fourth order.
    assert np.abs(extrapolated - own).max() < 0.02 * step_error
