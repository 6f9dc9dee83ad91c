"""The search for least squares on Rosenbrock's function, whose minimum is 0 at (1, 1).

Source: Rosenbrock, The Computer Journal 3 (1960) 175-184.
"""

import numpy as np

from fmus.mechanisms import Pendulum
from fmus.support.errors import InputError
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.levenberg_marquardt import Solution, levenberg_marquardt
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from tests.simulators.swings import swing


class Rosenbrock:
    """10 (x_2 - x_1^2), 1 - x_1; it cannot be computed where x_1 exceeds a limit."""

    def __init__(self, limit=np.inf):
        self.limit, self.last, self.best, self.rejected = limit, np.zeros(2), np.zeros(2), 0

    def residuals(self, x):
        if x[0] > self.limit:
            self.rejected += 1
            raise InputError("beyond the limit")
        self.last = x.copy()
        return np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])

    def slopes(self, x):
        return np.array([[-20 * x[0], 10.0], [-1.0, 0.0]])

    def accepted(self):
        self.best = self.last


def found(problem):
    start, free = np.array([-1.2, 1.0]), np.array([0, 1])
    bounds = np.full(2, -np.inf), np.full(2, np.inf)
    return levenberg_marquardt(problem, start, bounds, free, lambda x: np.full(2, 0.7), 1e-12, np.inf, np.inf, 200)


def test_the_minimum_is_found_and_the_last_accepted_point_is_the_solution():
    problem = Rosenbrock()
    solution = found(problem)
    np.testing.assert_allclose(solution.x, [1, 1], atol=1e-5)  # sqrt(1e-12) over the least singular value, 0.05
    np.testing.assert_array_equal(problem.best, solution.x)


def test_a_point_that_cannot_be_computed_is_never_accepted():
    problem = Rosenbrock(limit=0.5)
    solution = found(problem)
    assert problem.rejected and solution.x[0] <= 0.5
    np.testing.assert_array_equal(problem.best, solution.x)


def test_simulations_after_a_fit_begin_from_the_states_of_its_solution(monkeypatch):
    def rejecting(problem, x, *_):
        residuals, slopes = problem.residuals(x), problem.slopes(x)
        problem.accepted()
        problem.residuals(x + 0.05)  # a trial that is not accepted
        return Solution(x, float(residuals @ residuals), residuals, slopes)

    monkeypatch.setattr("motofmi.gap.estimation.fitting.levenberg_marquardt", rejecting)
    experiment = input_output_experiment(Pendulum(), ["angle"])
    values = {"J": 0.1, "k": 4.0, "c": 0.003, "T_c": 0.0, "c_2": 0.0}
    model = FreeInitialStateModel(experiment)
    found = fit(model, [prepare_sampled_run(swing("swing", 0.3, 12.0, 40.0, values, noise=1e-3), experiment)], model.start())
    np.testing.assert_array_equal(found.runs[0].guess[(*model.own, 0)]["at"], found.of_run(0))
