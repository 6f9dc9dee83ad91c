"""Initial states that an effect's equations bound: a normal prior, whose penalty is part of the misfit."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from scipy.signal import butter, lfilter

from fmus.effects.hysteresis import DahlHysteresis
from fmus.mechanisms import MassSpringDamper
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.recordings.recording import Recording

FORCE, WIDTH = 2.0, 0.02  # N, m
STEPS = 20  # of the simulation per sample


def shaken(time, force, x0):
    """The displacement of 1 kg on a spring of 40 N/m and a Dahl element, from displacement, speed and its state, by
    Heun's method with 20 steps per sample."""
    step = (time[1] - time[0]) / STEPS
    push = CubicSpline(time, force)(np.arange(STEPS * (len(time) - 1) + 1) * step).tolist()

    def rates(x, v, z, f):
        return v, f - v - 40 * x - FORCE * z, (v - abs(v) * z) / WIDTH

    states, found = tuple(map(float, x0)), [float(x0[0])]
    for k, (now, later) in enumerate(pairwise(push), 1):
        first = rates(*states, now)
        second = rates(*(x + step * r for x, r in zip(states, first, strict=True)), later)
        states = tuple(x + step * (r + s) / 2 for x, r, s in zip(states, first, second, strict=True))
        if k % STEPS == 0:
            found.append(states[0])
    return np.array(found)


@pytest.fixture(scope="module")
def recorded():
    """A run of 4 s that begins at 0.9 of the element's largest force, a model with the element, and the run's arrays."""
    time, rng = np.arange(0, 4, 0.01), np.random.default_rng(3)
    force = 20 * lfilter(*butter(2, 0.05), rng.standard_normal(len(time)))
    displacement = shaken(time, force, [0.0, 0.0, 0.9]) + 0.01 * rng.standard_normal(len(time))
    columns, units = {"force": force, "displacement": displacement}, {"force": "N", "displacement": "m"}
    recording = Recording("shaken", time, columns, units)
    test = input_output_experiment(MassSpringDamper(), recording.columns)
    model = FreeInitialStateModel(test).with_added_effects(DahlHysteresis)
    return prepare_sampled_run(recording, test), model, time, force


def vector(model, **values):
    """The vector of the model with the values above, or others of `names`."""
    known = {"mass": 1.0, "spring_stiffness": 40.0, "spring_damping": 1.0}
    known |= {"hysteresis.force": FORCE, "hysteresis.width": WIDTH} | values
    return np.array([np.log(known[n]) for n in model.base] + [known.get(n, 0.0) for n in model.own])


def residuals(run, model, q):
    output, slopes = model.reduced(run, q)
    return output - run.data / run.deviation, slopes


def test_the_misfit_is_that_of_the_best_initial_states_with_the_penalty_of_the_prior(recorded):
    run, model, time, force = recorded
    assert len(run.segments) == 1

    def states(unknowns):
        return np.array([0.01, 0.1, 1.0, 0.01]) * (unknowns - 1)  # of order one, for the finite differences

    def every_residual(unknowns):
        *x0, offset = states(unknowns)
        left = shaken(time, force, x0) + offset - run.measured[:, 0]
        return np.append(run.reduction.reduce_segments(left[None, :, None], [0])[0] / run.deviation, x0[2])

    expected = least_squares(every_residual, np.ones(4), diff_step=1e-4)
    state, error = states(expected.x)[2], np.sqrt(np.linalg.inv(expected.jac.T @ expected.jac)[2, 2])
    found, _ = residuals(run, model, vector(model))
    assert found @ found == pytest.approx(2 * expected.cost, rel=1e-3)
    assert abs(state) > 0.1  # the penalty is not zero
    known = run.guess[(*model.own, 0)]["initial"]
    assert known["hysteresis.sticking"] == pytest.approx(state, abs=0.2 * error)


def test_the_slopes_are_those_of_the_least_misfit(recorded):
    run, model, *_ = recorded
    for name in ("hysteresis.force", "hysteresis.width"):
        found, slopes = residuals(run, model, vector(model))
        known = {"hysteresis.force": FORCE, "hysteresis.width": WIDTH}[name]
        change = 1e-3 * known
        ahead, behind = (residuals(run, model, vector(model, **{name: known + d}))[0] for d in (change, -change))
        expected = (ahead @ ahead - behind @ behind) / (2 * change)
        assert 2 * found @ slopes[:, model.names.index(name)] == pytest.approx(expected, rel=0.02)


def test_a_force_that_no_initial_state_explains_does_not_give_a_state_far_beyond_its_bound(recorded):
    run, model, *_ = recorded
    weak = vector(model, **{"hysteresis.force": 1e-3 * FORCE})
    residuals(run, model, weak)
    assert abs(run.guess[(*model.own, 0)]["initial"]["hysteresis.sticking"]) < 2
