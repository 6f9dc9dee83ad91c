"""The touring motorcycle against the same bodies in Exudyn, alone and held by the FMU of a rider."""

import numpy as np
import pytest

from fmus import linearise
from motofmi.scenarios.hosts import exudyn_motorcycle
from vehicle_fmu import motorcycles

pytest.importorskip("exudyn", reason="Exudyn is not installed (the extra `hosts`)")


@pytest.mark.slow
@pytest.mark.parametrize("speed", [10.0, 60.0])
def test_every_eigenvalue_is_that_of_the_multibody_motorcycle(speed):
    motorcycle = motorcycles.load("tum_2020")
    ours = np.linalg.eigvals(linearise(motorcycle, speed=speed).A)
    coarse, fine = (exudyn_motorcycle.eigenvalues(motorcycle, speed, step) for step in (1e-3, 5e-4))
    errors = [max(np.abs(found - z).min() / abs(z) for z in ours) for found in (coarse, fine)]
    assert errors[1] < 1e-3
    # What differs is the error of the step, of second order: the tyres and the bodies are two objects of Exudyn.
    assert errors[1] < errors[0] / 3


@pytest.mark.study
def test_where_capsize_crosses_zero_it_is_that_of_the_multibody_motorcycle():
    motorcycle = motorcycles.load("tum_2020")
    capsize = min(np.linalg.eigvals(linearise(motorcycle, speed=36.6).A), key=abs)
    found = exudyn_motorcycle.eigenvalues(motorcycle, 36.6)
    assert abs(capsize) < 0.02  # 1/s
    assert np.abs(found - capsize).min() < 1e-6 * abs(capsize)  # slow: no error of the step


@pytest.mark.slow
def test_with_the_riders_fmu_it_moves_as_the_one_linear_system():
    found = exudyn_motorcycle.run(duration=0.2)
    # FMU and motorcycle meet every 0.5 ms; the error of that coupling is of the second order, 2e-4 here.
    assert max(found.values()) < 1e-3
