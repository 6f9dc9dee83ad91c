"""The touring motorcycle in a corner against the same bodies in Exudyn."""

import pytest

from motofmi.scenarios.hosts import exudyn_corner
from vehicle_fmu import motorcycles

pytest.importorskip("exudyn", reason="Exudyn is not installed (the extra `hosts`)")


@pytest.mark.study
@pytest.mark.parametrize("speed, lean", [(10.0, 30.0), (30.0, 15.0), (30.0, 30.0), (30.0, 45.0), (60.0, 45.0)])
def test_equilibrium_and_eigenvalues_are_those_of_the_multibody_motorcycle(speed, lean):
    left, errors = exudyn_corner.compared(motorcycles.load("tum_2020"), speed, lean)
    assert left < 1e-8  # m/s2, rad/s2: rounding of Newton's methods for loads of 1400 N
    assert errors.max() < 1e-3  # central differences; with steps from 1e-5 to 1e-6 they fall with the square


@pytest.mark.study
def test_what_differs_is_the_error_of_the_differences(monkeypatch):
    found = []
    for change in (1e-5, 3e-6):
        monkeypatch.setattr(exudyn_corner, "CHANGE", change)
        found.append(exudyn_corner.compared(motorcycles.load("tum_2020"), 30.0, 45.0)[1].max())
    assert found[0] / found[1] == pytest.approx((1e-5 / 3e-6) ** 2, rel=0.1)
