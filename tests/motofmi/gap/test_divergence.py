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
from motofmi.gap.models.segmented import SegmentedModel
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


def test_of_many_pieces_all_that_diverge_are_known_at_once():
    """The largest initial values overflow in the first steps of Newton's method, the others later or not at all."""
    infinite = np.arange(0, 24, 3)
    initial = np.full(24, 0.5)
    initial[infinite] = np.geomspace(1.02, 1e60, len(infinite))
    with pytest.raises(DivergenceError) as raised:
        pieces(initial)
    assert raised.value.pieces.tolist() == infinite.tolist()


class Diverging(SegmentedModel):
    """Segments of which some diverge, together with others or alone as well; the simulations are counted."""

    def __init__(self, together, alone):
        self.together, self.alone, self.simulations = together, alone, []

    def simulated(self, run, indices, values, initial, length=0, **options):
        self.simulations.append(indices)
        diverging = [k for k, i in enumerate(indices) if i in (self.alone if len(indices) == 1 else self.together)]
        if diverging:
            raise DivergenceError("diverges", np.array(diverging))
        return None, None


@pytest.mark.parametrize(("alone", "found", "simulations"), [
    ([], {5, 11, 17}, 5),  # all, those that do not diverge, and each of the three
    ([5, 11, 17], set(), 3),  # the first of the three diverges alone: the others are not tried
    ([11], {5}, 4),
])  # fmt: skip
def test_of_many_segments_those_that_diverge_are_simulated_alone(alone, found, simulations):
    model, every = Diverging([5, 11, 17], alone), list(range(40))
    yielded = [indices for indices, *_ in model.simulated_apart(None, every, {}, {})]
    assert yielded[0] == [i for i in every if i not in (5, 11, 17)]
    assert {i for some in yielded[1:] for i in some} == found and len(model.simulations) == simulations


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
