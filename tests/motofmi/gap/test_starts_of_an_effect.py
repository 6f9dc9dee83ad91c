"""The starts from which an effect is fitted, on a pendulum that swings wide, whose stiffness follows the sine."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fmus.effects.stiffness import GeometricNonlinearity
from fmus.mechanisms.pendulum import Pendulum
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation import effect_fit
from motofmi.gap.estimation.candidate import adequate
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.screening import screen
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording


def swing() -> Recording:
    """20 s at 50 Hz of q'' = -0.1 q' - 9.81 sin(q), released at 1.2 rad."""
    time = np.arange(0, 20, 0.02)
    angle = solve_ivp(
        lambda t, x: [x[1], -0.1 * x[1] - 9.81 * np.sin(x[0])], (0, 20), [1.2, 0.0], t_eval=time, rtol=1e-9, atol=1e-9
    ).y[0]
    noisy = angle + 1e-4 * np.random.default_rng(0).standard_normal(len(time))
    return Recording("swing", time, {"angle": noisy}, {"angle": "rad"})


@pytest.mark.parametrize("scaled, starts", [(1.0, 1), (1e9, 2)], ids=["inadequate base", "adequate base"])
def test_an_adequate_fit_ends_the_starts_only_where_the_base_is_not_adequate(monkeypatch, scaled, starts):
    """Where the noise comes from the residuals of the base, the base is adequate, and so is a fit that ended early."""
    experiment = input_output_experiment(Pendulum(), ["angle"])
    model = FreeInitialStateModel(experiment)
    base = fit(model, [prepare_sampled_run(swing(), experiment)], model.start()).with_scaled_noise(scaled)
    assert adequate(base, Criteria()) == (starts > 1)
    (signature,) = screen(base, [GeometricNonlinearity], keep=1)
    begun = []

    def counted(model, runs, start, **options):
        """The first fit is adequate, and gains less than was estimated."""
        begun.append(fit(model, runs, start, **options))
        if len(begun) > 1:
            return begun[-1]
        left = min(0.9 * base.chi2, 0.5 * base.freedom)
        return begun[0].with_scaled_noise(begun[0].chi2 / left)

    monkeypatch.setattr(effect_fit, "fit", counted)
    effect_fit.best_portable_fit(base, replace(signature, gain=base.chi2), np.inf, [], Criteria())
    assert len(begun) == starts


@pytest.mark.parametrize("rival", [False, True], ids=["without a rival", "with a rival"])
def test_a_start_that_is_far_from_the_data_is_fitted_only_where_no_rival_is_known(rival, monkeypatch):
    """Without the sine the angle of this pendulum differs by rad, of which the noise is 1e-4: a ratio of 1e8 to the
    chi-square of the pendulum that has it."""
    experiment = input_output_experiment(Pendulum(), ["angle"])
    model = FreeInitialStateModel(experiment)
    base = fit(model, [prepare_sampled_run(swing(), experiment)], model.start())
    (signature,) = screen(base, [GeometricNonlinearity], keep=1)
    (sine,) = effect_fit.fit_from_further_starts(base, [signature], np.inf)
    pendulum, fits = replace(base, x=sine.fit.x[:-1], chi2=sine.fit.chi2), []
    monkeypatch.setattr(effect_fit, "fit", lambda *args, **options: fits.append(fit(*args, **options)) or fits[-1])
    effect_fit.fit_from_further_starts(
        pendulum, [replace(signature, start=np.zeros(1))], sine.fit.chi2 if rival else np.inf
    )
    assert [found.chi2 > 1e4 * sine.fit.chi2 for found in fits] == [rival]
