"""The errors by which a magnitude is compared with zero, on regressions whose likelihood ratio is known exactly."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import least_squares

from fmus.effects.damping import CoulombFriction, LaggingFriction
from motofmi.gap.comparison.adjusted_likelihood_ratio import adjusted_errors
from motofmi.gap.estimation.fit_result import Fit

TIME = np.linspace(0.0, 1.0, 50)
ERROR = 0.1


def regression(formula, data, effect=CoulombFriction):
    """The fit of a formula of one magnitude, with the noise `ERROR`, and the one with the magnitude zero."""
    solved = least_squares(lambda x: (formula(x) - data) / ERROR, [1.0])
    experiment = SimpleNamespace(parameter=lambda effect, n: f"{effect.family}.{n}")
    names = [f"{effect.family}.{n}" for n in effect.free_parameters()]
    made = [
        Fit(SimpleNamespace(names=names[:count], effects=(effect,) * count, experiment=experiment), [], x,
            float(residuals @ residuals), residuals, jacobian, len(data))
        for count, x, residuals, jacobian in (
            (1, solved.x, solved.fun, solved.jac), (0, np.zeros(0), data / ERROR, np.zeros((len(data), 0))),
        )
    ]  # fmt: skip
    made[1].model.effects = ()
    return made


def error_of(found):
    return np.sqrt(np.diag(found.covariance()))


def test_where_the_output_is_linear_in_the_magnitude_the_errors_stay():
    noise = ERROR * np.random.default_rng(0).standard_normal(len(TIME))
    found, without = regression(lambda x: x * np.sin(9 * TIME), 0.05 * np.sin(9 * TIME) + noise)
    errors = 3 * error_of(found)  # of a model that is incomplete
    assert adjusted_errors(found, errors, [without]) == pytest.approx(errors, rel=1e-6)  # z^2 = L, by least squares


def rigid():
    """1 - exp(-200 t) on samples of 0.02 s: all but the first are one, whatever the rate."""
    data = 1 - np.exp(-200 * TIME) + ERROR * np.random.default_rng(1).standard_normal(len(TIME))
    return regression(lambda x: 1 - np.exp(-np.abs(x) * TIME), data)


def test_a_magnitude_to_which_the_output_is_rigid_is_distinguished_from_zero_by_its_likelihood_ratio():
    found, without = rigid()
    errors = error_of(found)
    assert abs(found.x[0]) < 2 * errors[0]  # not distinguishable by its standard error
    adjusted = adjusted_errors(found, errors, [without])
    assert found.x / adjusted == pytest.approx(np.sqrt(without.chi2 - found.chi2))  # about 69


def test_errors_of_the_model_are_kept_in_proportion():
    found, without = rigid()
    single, triple = (adjusted_errors(found, k * error_of(found), [without]) for k in (1.0, 3.0))
    assert triple == pytest.approx(3 * single)


def test_without_a_fit_that_lacks_the_effect_the_errors_stay():
    found, _ = rigid()
    assert np.array_equal(adjusted_errors(found, error_of(found), [found]), error_of(found))


def test_an_effect_with_states_keeps_its_errors_since_initial_states_gain_without_a_magnitude():
    noise = 1 + ERROR * np.random.default_rng(1).standard_normal(len(TIME))
    found, without = regression(lambda x: 1 - np.exp(-np.abs(x) * TIME), noise, LaggingFriction)
    assert np.array_equal(adjusted_errors(found, error_of(found), [without]), error_of(found))
