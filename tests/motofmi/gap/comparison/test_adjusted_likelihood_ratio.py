"""The errors by which a magnitude is compared with zero, on regressions whose likelihood ratio is known exactly."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import least_squares

from fmus.effects.damping import SoftFriction
from fmus.effects.hysteresis import DahlHysteresis
from motofmi.gap.comparison import adjusted_likelihood_ratio
from motofmi.gap.comparison.adjusted_likelihood_ratio import adjusted_errors
from motofmi.gap.estimation.fit_result import Fit

TIME = np.linspace(0.0, 1.0, 50)
ERROR = 0.1
LEAST = 2.0  # standard errors


class Regression:
    """A model y = formula(x) of one effect's parameters, or y = 0 without the effect, as the fits use it."""

    predicted, base, rows = None, (), ()

    def __init__(self, formula, data, effects):
        self.formula, self.data, self.effects = formula, data, effects
        self.experiment = SimpleNamespace(parameter=lambda effect, n: f"{effect.family}.{n}", free=())
        self.names = [f"{e.family}.{n}" for e in effects for n in e.free_parameters()]
        self.own = self.names


def regression(formula, data, effect, start):
    """The fit of a formula of an effect's parameters, with the noise `ERROR`, and the one without the effect."""
    solved = least_squares(lambda x: (formula(x) - data) / ERROR, start, x_scale=np.abs(start))
    empty = Fit(Regression(formula, data, ()), [], np.zeros(0), float(np.sum((data / ERROR) ** 2)), data / ERROR,
                np.zeros((len(data), 0)), len(data))  # fmt: skip
    found = Fit(Regression(formula, data, (effect,)), [], solved.x, float(solved.fun @ solved.fun), solved.fun, solved.jac,
                len(data))  # fmt: skip
    return found, empty


@pytest.fixture(autouse=True)
def nothing_to_refit(monkeypatch):
    """The fit without the effect has no parameters."""
    monkeypatch.setattr(adjusted_likelihood_ratio, "fit", lambda model, runs, start: SimpleNamespace(chi2=np.inf))


def error_of(found):
    return np.sqrt(np.diag(found.covariance()))


def step(x):
    """A friction that saturates at once: x_0 is its magnitude above the width x_1, about the time of the step."""
    return np.tanh(np.abs(x[0]) * (TIME - np.abs(x[1])) * 100)


def rigid(effect=SoftFriction):
    """A step at 0.5 s between samples 0.02 s apart: any magnitude above 3 gives the same, the time is determined."""
    data = step([50.0, 0.5]) + ERROR * np.random.default_rng(1).standard_normal(len(TIME))
    return regression(step, data, effect, [3.0, 0.5])


def test_where_the_output_is_linear_in_the_magnitude_the_errors_stay():
    noise = ERROR * np.random.default_rng(0).standard_normal(len(TIME))
    found, without = regression(lambda x: x[0] * np.sin(9 * TIME) + x[1] * np.cos(9 * TIME), 0.01 * np.sin(9 * TIME)
                                + np.cos(9 * TIME) + noise, SoftFriction, [1.0, 1.0])  # fmt: skip
    without.chi2 = float(np.sum(((np.cos(9 * TIME) * found.x[1] - found.model.data) / ERROR) ** 2))
    errors = 3 * error_of(found)  # of a model that is incomplete
    assert abs(found.x[0]) < LEAST * errors[0] and found.x[1] > LEAST * errors[1]
    # z^2 = L by least squares, but for the small change of the second parameter without the first
    assert adjusted_errors(found, errors, [without], LEAST) == pytest.approx(errors, rel=0.02)


def test_a_magnitude_to_which_the_output_is_rigid_is_distinguished_from_zero_by_its_likelihood_ratio():
    found, without = rigid()
    errors = np.array([3 * error_of(found)[0], 1e-3])
    assert abs(found.x[0]) < LEAST * errors[0]  # not distinguishable by its standard error
    adjusted = adjusted_errors(found, errors, [without], LEAST)
    plain = np.sqrt(replace(found, sandwich=None).covariance()[0, 0])
    ratio = np.sqrt(without.chi2 - found.chi2)  # about 70
    assert found.x[0] / adjusted[0] == pytest.approx(ratio * plain / errors[0]) and plain > found.x[0] / LEAST
    assert adjusted[1] == errors[1]


def test_a_magnitude_that_only_errors_of_the_model_hide_keeps_its_errors():
    found, without = rigid()
    found.jacobian = found.jacobian * [1e9, 1.0]  # many standard errors without errors of the model
    errors = np.array([100.0, 1e-3])
    assert np.array_equal(adjusted_errors(found, errors, [without], LEAST), errors)


def test_an_effect_of_which_the_data_determine_nothing_keeps_its_errors():
    found, without = rigid()
    errors = np.array([100.0, 100.0])
    assert np.array_equal(adjusted_errors(found, errors, [without], LEAST), errors)


def test_without_a_fit_that_lacks_the_effect_the_errors_stay():
    found, _ = rigid()
    errors = np.array([100.0, 1e-3])
    assert np.array_equal(adjusted_errors(found, errors, [found], LEAST), errors)


def test_a_better_minimum_of_the_base_is_no_gain_of_the_effect(monkeypatch):
    found, without = rigid()
    errors = np.array([100.0, 1e-3])
    again = SimpleNamespace(chi2=found.chi2)  # the base alone fits as well from these values
    monkeypatch.setattr(adjusted_likelihood_ratio, "fit", lambda model, runs, start: again)
    assert np.array_equal(adjusted_errors(found, errors, [without], LEAST), errors)


def test_an_effect_with_states_keeps_its_errors_since_initial_states_gain_without_a_magnitude():
    found, without = rigid(DahlHysteresis)
    errors = np.array([100.0, 1e-3])
    assert np.array_equal(adjusted_errors(found, errors, [without], LEAST), errors)
