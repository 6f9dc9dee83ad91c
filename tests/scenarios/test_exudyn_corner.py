"""The touring motorcycle in a corner against the same bodies in Exudyn, and against eigenvalues stored from it."""

import json
from pathlib import Path

import numpy as np
import pytest

from motofmi.scenarios.hosts import exudyn_corner
from rider_fmu import riders
from tests import sampled
from tests.vehicle_fmu.test_large_motion import LOCKED, TUM
from vehicle_fmu.large_motion.corner_modes import corner_modes, held
from vehicle_fmu.large_motion.equations import LargeMotion
from vehicle_fmu.large_motion.steady_turning import SteadyTurning

STORED = json.loads((Path(__file__).parent / "eigenvalues_by_exudyn.json").read_text("utf-8"))
STILL = TUM.with_values(rider_slide=0.0, rider_lean=0.0)
DEVICES = {"hands off": (), "mean rider": (riders.load("mean_2011"),)}


@pytest.mark.slow
@pytest.mark.parametrize("case", sampled(STORED["cases"], 4), ids=lambda c: f"{c['speed']:g}-{c['lean']:g}-{c['acceleration']:g}-{c['hands']}")
def test_eigenvalues_are_those_stored_from_exudyn(case):
    """`python -m tests.scenarios.eigenvalues_by_exudyn` stores them, by central differences of Exudyn's
    accelerations."""
    devices = DEVICES[case["hands"]]
    turning = SteadyTurning(LargeMotion(held(TUM, devices)), case["speed"])
    point = np.radians([case["lean"]]), np.array([case["acceleration"]])
    own = corner_modes(turning, TUM, devices, *point).eigenvalues[0]
    theirs = np.array(case["real"]) + 1j * np.array(case["imag"])
    errors = np.abs(theirs[:, None] - own).min(axis=0) / np.abs(own)
    assert len(theirs) == len(own) and errors.max() < 1e-3  # error of central differences


@pytest.mark.study
@pytest.mark.parametrize("motorcycle", [LOCKED, TUM, STILL], ids=["locked", "free", "rider locked"])
@pytest.mark.parametrize("speed, lean", [(10.0, 30.0), (30.0, 15.0), (30.0, 30.0), (60.0, 30.0)])
def test_equilibrium_and_eigenvalues_are_those_of_the_multibody_motorcycle(motorcycle, speed, lean):
    pytest.importorskip("exudyn", reason="Exudyn is not installed (the extra `hosts`)")
    left, errors = exudyn_corner.compared(motorcycle, speed, lean)
    assert left < 1e-6  # m/s2, rad/s2, 1/s: rounding of differences along the motion
    assert errors.max() < 1e-3  # central differences; with steps from 1e-5 to 1e-6 they fall with the square


@pytest.mark.study
def test_what_differs_is_the_error_of_the_differences(monkeypatch):
    pytest.importorskip("exudyn", reason="Exudyn is not installed (the extra `hosts`)")
    found = []
    for change in (1e-5, 3e-6):
        monkeypatch.setattr(exudyn_corner, "CHANGE", change)
        found.append(exudyn_corner.compared(LOCKED, 30.0, 45.0)[1].max())
    assert found[0] / found[1] == pytest.approx((1e-5 / 3e-6) ** 2, rel=0.1)


@pytest.mark.study
def test_some_free_deflections_are_refused():
    pytest.importorskip("exudyn", reason="Exudyn is not installed (the extra `hosts`)")
    some = TUM.with_values()
    some.supplement["front_tyre_deflection"] = 0.0
    with pytest.raises(ValueError, match="must all be free or all be locked"):
        exudyn_corner.compared(some, 30.0, 0.0)
