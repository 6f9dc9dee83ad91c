"""A simulation of several pieces that diverges in some of them."""

import numpy as np
import pytest

from fmus import Component, input, state
from fmus.effects.placement import laws_at
from fmus.mechanisms import DrivenJoint
from fmus.support.errors import InputError
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.collocation import DivergenceError, Motion
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.models.simulation import simulate
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from tests.simulators.hidden_joint import joint_run


class Escape(Component):
    """der(x) = x^2 + u: for u = 0 x = x_0 / (1 - x_0 t), infinite at t = 1 / x_0."""

    u = input("1/s", "Input")
    x = state("1", "State", exposed=True)

    def equations(self, v, m):
        return {"der(x)": v.x**2 + v.u}


STEPS, STEP = 40, 0.025  # of every piece: 1 s


def pieces(initial):
    """The states (pieces, STEPS + 1) from initial values (pieces,)."""
    equations, count = Equations(Escape(), ["x"], []), STEPS + 1
    begins = np.arange(len(initial)) * count
    time = np.arange(len(initial) * count) * STEP
    motion = Motion(time, {"u": np.zeros(len(time))}, {"u": np.zeros(len(time) - 1)}, begins)
    begin = np.array(initial)[:, None]
    made = simulate(equations, Escape().start_values(), motion, None, begin, with_initial=True)
    return made.states[:, 0].reshape(len(initial), -1)


def test_pieces_that_remain_finite_are_exact():
    initial, t = np.array([-2.0, 0.1, 0.5]), np.arange(STEPS + 1) * STEP
    # 1e-6: the formula of fourth order, with steps of 1/40 of the time to infinity
    assert pieces(initial) == pytest.approx(initial[:, None] / (1 - initial[:, None] * t), rel=1e-6)


@pytest.mark.parametrize("infinite", [[1], [0, 3], [4], [2, 3, 4]])
def test_the_pieces_that_diverge_are_known(infinite):
    """Pieces from 1.5 are infinite after 2/3 s, those from 0.5 would be after 2 s."""
    initial = np.where(np.isin(np.arange(5), infinite), 1.5, 0.5)
    with pytest.raises(DivergenceError, match="Escape: the simulation diverges") as raised:
        pieces(initial)
    assert raised.value.pieces.tolist() == infinite
    t, others = np.arange(STEPS + 1) * STEP, np.setdiff1d(np.arange(5), infinite)
    exact = np.tile(0.5 / (1 - 0.5 * t), (len(others), 1))  # see above for the tolerance
    assert raised.value.states[:, 0].reshape(5, -1)[others] == pytest.approx(exact, rel=1e-6)


@pytest.mark.slow
def test_one_segment_that_diverges_is_left_out():
    sampled = prepare_sampled_run(
        joint_run({}, "random", seed=5, duration=12.0), input_output_experiment(DrivenJoint(), ["torque", "angle"])
    )
    law = next(
        e for e in laws_at(sampled.experiment.component) if e.form == "square" and e.family == "hardening_stiffness"
    )
    model = FreeInitialStateModel(sampled.experiment, [law])
    base = model.start()[: len(model.base)]
    values = model.values(np.append(base, 10.0))
    initial = {i: np.zeros(2) for i in range(len(sampled.segments))} | {2: np.array([np.nan, 0.0])}
    found = [indices for indices, *_ in model.simulated_apart(sampled, list(initial), values, initial)]
    assert found == [[i for i in initial if i != 2]]  # all others in one simulation
    with pytest.raises(InputError, match="diverges from"):
        model.from_rest(sampled, np.append(base, np.nan))
