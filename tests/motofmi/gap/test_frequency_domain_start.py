"""Starting values from the frequency domain: components whose own values are wrong by a factor of 30 are recovered.

The recordings are simulated by scipy's `solve_ivp`; free motions are exact solutions of linear equations.
"""

from itertools import combinations

import numpy as np
import pytest
from scipy.linalg import expm

from fmus import Component
from fmus.mechanisms import MassSpringDamper
from motofmi.gap.estimation.frequency_domain_fit import frequency_domain_start
from motofmi.gap.estimation.initial_fit import initial_fit
from motofmi.gap.estimation.local_polynomial import local_polynomial_response
from motofmi.gap.estimation.starting_values import first_values
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording
from tests.simulators.other_components import (
    Accelerometer,
    Tanks,
    TwoCarts,
    accelerometer_run,
    carts_run,
    tanks_run,
)

CARTS = {
    "mass": 1.3,
    "other_mass": 0.8,
    "ground_stiffness": 150.0,
    "stiffness": 220.0,
    "damping": 2.0,
    "other_damping": 1.5,
}
ACCELEROMETER = {"mass": 2.0, "stiffness": 300.0, "damping": 4.0}
FACTORS = (30.0, 1 / 30)


def prepared(
    component: Component, recording: Recording, free: tuple[str, ...] = ()
) -> tuple[FreeInitialStateModel, SampledRun]:
    experiment = input_output_experiment(component, list(recording.columns), free=free)
    return FreeInitialStateModel(experiment), prepare_sampled_run(recording, experiment)


def values_from(component: Component, recording: Recording, free: tuple[str, ...] = ()) -> dict[str, float]:
    model, run = prepared(component, recording, free)
    found = frequency_domain_start(model, [run])
    assert found is not None
    return dict(zip(model.base, np.exp(found).tolist(), strict=True))


@pytest.fixture(scope="module")
def carts() -> Recording:
    return carts_run("carts", 1)


def test_every_start_is_tried_once():
    """Tanks have no stiffness to be multiplied: that start would be tried five times."""
    model, run = prepared(Tanks(), tanks_run("tanks", 1))
    starts = list(first_values(model, [run]))
    assert len(starts) > 1
    assert not any(np.allclose(one, other) for one, other in combinations(starts, 2))


@pytest.mark.slow
@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("wrong", [("stiffness", "ground_stiffness"), ("mass", "other_mass")])
def test_two_forces_and_two_positions_recover_values_that_are_wrong_by_thirty(carts, wrong, factor):
    own = {n: CARTS[n] * (factor if n in wrong else 1.0) for n in CARTS}
    found = values_from(TwoCarts(**own), carts)
    # With noise of 1 % of each position in 2,000 samples an entry has a standard error below 1 %
    assert found == pytest.approx(CARTS, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("factor", FACTORS)
def test_components_that_are_slower_or_faster_throughout_are_recovered(carts, factor):
    """With time stretched by tau, masses are tau^2 and dampers tau times as large at the same forces and positions."""
    slow = Recording("slow", factor * carts.time, dict(carts.columns), carts.units)
    exponents = {"mass": 2, "other_mass": 2, "damping": 1, "other_damping": 1}
    expected = {n: x * factor ** exponents.get(n, 0) for n, x in CARTS.items()}
    assert values_from(TwoCarts(**CARTS), slow) == pytest.approx(expected, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("factor", FACTORS)
def test_the_fit_over_time_starts_from_there(factor):
    own = ACCELEROMETER | {"stiffness": factor * ACCELEROMETER["stiffness"]}
    model, run = prepared(Accelerometer(**own), accelerometer_run("shaken", 1))
    found = initial_fit(model, [run])
    # 2,000 samples with noise of 1 %: standard errors are below 0.1 %
    assert dict(zip(model.base, np.exp(found.shared), strict=True)) == pytest.approx(ACCELEROMETER, rel=0.005)


def values_from_decay(k: float, c: float, rate: float, duration: float, own: dict[str, float]) -> dict[str, float]:
    """The values found from a free motion x'' = -k x - c x' from 0.03 m, with noise, for a base with its own values."""
    time = np.arange(0, duration, 1 / rate)
    step = expm(np.array([[0.0, 1.0], [-k, -c]]) / rate)
    states = [np.array([0.03, 0.0])]
    for _ in time[1:]:
        states.append(step @ states[-1])
    x = np.array(states)[:, 0] + 2e-4 * np.random.default_rng(1).standard_normal(len(time))
    component = MassSpringDamper(mass=1.0, **own)
    return values_from(component, Recording("decay", time, {"displacement": x}, {"displacement": "m"}), tuple(own))


@pytest.mark.parametrize("own", [30.0, 3e4])
def test_of_two_frequencies_with_the_same_samples_the_slower_one_is_found(own):
    """At 30 Hz a decay of 1.17 Hz has the samples of one of 28.8 Hz."""
    found = values_from_decay(54.0, 0.27, 30.0, 10.0, {"spring_stiffness": own, "spring_damping": 0.2})
    assert found["spring_stiffness"] == pytest.approx(54.0, rel=0.01)  # 12 periods of noise 0.7 % of the release


@pytest.mark.parametrize("factor", FACTORS)
def test_a_free_decay_without_input_recovers_frequency_and_damping(factor):
    k, c = 720.0, 6.0
    found = values_from_decay(k, c, 64.0, 20.0, {"spring_stiffness": factor * k, "spring_damping": c})
    # 20 periods of noise 0.7 % of the release: the frequency is known to 0.1 %, the damping to 1 %
    assert found["spring_stiffness"] == pytest.approx(k, rel=0.01)
    assert found["spring_damping"] == pytest.approx(c, rel=0.05)


def test_the_response_of_a_digital_filter_without_a_model():
    """y_k = 0.9 y_k-1 + u_k, of response 1 / (1 - 0.9 exp(-i w)), from a record that is not periodic."""
    rng = np.random.default_rng(2)
    u, y = rng.standard_normal(4096), np.zeros(4096)
    for k in range(1, 4096):
        y[k] = 0.9 * y[k - 1] + u[k]
    omega = 2 * np.pi * np.arange(1, 2000) / 4096
    spectra = (np.fft.rfft(x)[1:2000, None] for x in (u, y))
    found = local_polynomial_response(omega, *spectra)
    assert found is not None
    exact = 1 / (1 - 0.9 * np.exp(-1j * found.omega))
    assert np.max(np.abs(found.response[:, 0, 0] / exact - 1)) < 0.01  # the polynomial's error over 13 lines
