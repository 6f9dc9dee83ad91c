"""Chi-square in units of what the best effect leaves: a swing with dry friction by SciPy, and a linear pendulum."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus.mechanisms import Pendulum
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base
from motofmi.gap.estimation.effect_fit import best_portable_fit, candidate_of
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.screening import screen
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.by_comparison import in_units_of_residuals
from motofmi.recordings.recording import Recording
from motofmi.workflows.gap.input_output import anchored


def swing(released, friction):
    """A free swing with J = 1 kg.m2, m g l = 60 N.m, c = 0.3 N.m.s/rad, and a friction torque [N.m]; 6 s at 100 Hz."""
    time = np.arange(600) / 100

    def rates(_, x):
        return [x[1], -60 * np.sin(x[0]) - 0.3 * x[1] - friction * np.tanh(x[1] / 0.02)]

    found = solve_ivp(rates, (0, 6), [released, 0.0], t_eval=time, rtol=1e-8, atol=1e-10, max_step=0.005)
    noise = 1e-3 * np.random.default_rng(3).standard_normal(len(time))
    return Recording(f"from {released} rad", time, {"angle": found.y[0] + noise}, {"angle": "rad"})


@pytest.fixture(scope="module")
def swings():
    """The base, the library, and the fitted effect of the sine."""
    experiment, _ = anchored(input_output_experiment(Pendulum(), ["angle"]))
    runs = [prepare_sampled_run(swing(2.0, 1.0), experiment)]
    based = fitted_base(experiment, runs, {}, (), Criteria())
    base, library = based.fit, based.candidates
    sine = next(s for s in screen(base, library, keep=1) if s.effect.family == "geometric_nonlinearity")
    return base, library, candidate_of(base, sine, best_portable_fit(base, sine, np.inf, [], Criteria()))


def test_a_fit_with_scaled_noise_is_that_of_its_runs_with_scaled_noise(swings):
    found = swings[2].fit
    scaled = found.with_scaled_noise(0.01)
    again = fit(scaled.model, scaled.runs, scaled.x, iterations=0)
    assert scaled.chi2 == pytest.approx(100 * found.chi2) and scaled.reduced == pytest.approx(100 * found.reduced)
    assert again.chi2 == pytest.approx(scaled.chi2, rel=1e-3)
    assert again.jacobian == pytest.approx(scaled.jacobian, rel=0.01, abs=0.01 * np.abs(scaled.jacobian).max())


def test_the_best_effect_leaves_the_noise_and_a_second_one_beside_it_is_found(swings):
    base, library, sine = swings
    assert sine.fit.chi2 < 0.01 * base.chi2  # in the noise of the base every second effect would gain next to nothing
    base, (sine,), _ = in_units_of_residuals(sine.fit, base, [sine], [])
    assert sine.fit.chi2 == pytest.approx(sine.fit.count, rel=1e-6) and base.chi2 > 100 * sine.fit.chi2
    friction = [e for e in library if e.family == "coulomb_friction" and e.form == "coulomb"]
    signature = screen(sine.fit, friction, keep=1)[0]
    found = candidate_of(sine.fit, signature, best_portable_fit(sine.fit, signature, np.inf, [], Criteria()))
    values = found.fit.model.values(found.fit.shared)
    torque = next(value for name, value in values.items() if name.endswith("friction_torque"))
    assert torque / values["inertia"] == pytest.approx(1.0, rel=0.03)
