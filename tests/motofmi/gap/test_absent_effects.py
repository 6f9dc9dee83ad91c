"""Effects that are absent do not change the motion of the model to which they are added: its trajectory is kept."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import butter, lfilter

from fmus import Component, input, state
from fmus.effects.placement import laws_at
from fmus.mechanisms import MassSpringDamper
from motofmi.gap.comparison.compared_model import CommonBlocks
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import initial_guesses, with_initial_guesses
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.screening import simulated_again
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.collocation import Motion, inner_times
from motofmi.gap.models.equations import Equations
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.models.simulation import simulate
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run
from motofmi.recordings.recording import Recording
from motofmi.workflows.gap.rig import rig_effects, rig_experiment

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from tests.simulators.as_recordings import as_recording
from tests.simulators.hidden_rig import RIDER, record, sweep
from tests.simulators.rig_runs import RIG


class Followed(Component):
    """A state that an input drives, and another one that follows it."""

    push = input("m/s", "Rate")
    leader = state("m", "State that is driven", exposed=True)
    follower = state("m", "State that follows it")

    def equations(self, v, m):
        return {"der(leader)": v.push, "der(follower)": 5 * (v.leader - v.follower)}


def test_a_held_state_keeps_its_guess_and_the_others_follow_it():
    time = np.arange(0, 4, 0.01)
    motion = Motion(time, {"push": np.cos(time)}, {"push": np.cos(inner_times(time))})
    equations = Equations(Followed(), ["leader"], ())
    # As a trajectory with kinks, the leader's solves its equations within the accuracy of Newton's method only.
    kept = np.sin(time) + 1e-6 * np.random.default_rng(1).standard_normal(len(time)) * (time > 0)
    guess = np.column_stack([kept, np.zeros_like(time)])
    of_held, of_all = (simulate(equations, {}, motion, guess, np.zeros(2), held=count).states for count in (1, 0))
    np.testing.assert_array_equal(of_held[:, 0], kept)
    assert np.abs(of_all[:, 0] - kept).max() > 1e-6
    expected = solve_ivp(lambda t, z: 5 * (np.sin(t) - z), (0, 4), [0.0], t_eval=time, rtol=1e-10, atol=1e-12).y[0]
    # It follows the errors of the leader, of 1e-6 each and 3e-6 at most.
    assert of_held[:, 1] == pytest.approx(expected, abs=5e-6)


def of_a_rider():
    """A rider without effects, fitted to a sweep in which friction and a reflex are hidden."""
    arrays = record(sweep(0.5, 8, 3, 40.0), {"kr": 15.0, "tau": 0.1, "Tc": 0.3}, RIDER, np.random.default_rng(5))
    run = prepare_steer_test_run(as_recording("sweep", arrays), "steer_angle", "steer_torque", "steer_angle_command")
    model = HarmonicModel(rig_experiment(RIG))
    return fit(model, [run], model.start()), [effect for effect in rig_effects() if effect.prior is None]


def of_a_mass():
    """A mass on a linear spring, fitted to a motion at random of a mass on a hardening one."""
    time, rng = np.arange(0, 20, 0.01), np.random.default_rng(3)
    force = lfilter(*butter(2, 0.06), rng.standard_normal(len(time)))
    found = solve_ivp(lambda t, x: [x[1], np.interp(t, time, force) - x[1] - 40 * x[0] - 2e4 * x[0] ** 3], (0, time[-1]), [0, 0],
                      t_eval=time, rtol=1e-8, atol=1e-12).y[0]  # fmt: skip
    columns = {"force": force, "displacement": found + 1e-5 * rng.standard_normal(len(time))}
    recording = Recording("pushed", time, columns, {"force": "N", "displacement": "m"})
    test = input_output_experiment(MassSpringDamper(), recording.columns)
    model = FreeInitialStateModel(test)
    return fit(model, [prepare_sampled_run(recording, test)], model.start()), laws_at(MassSpringDamper())


def absent(effect, table):
    """The values of an effect's parameters with its magnitudes at zero, where they may be, and the others at their
    start."""
    magnitudes = effect.magnitudes()
    return [0.0 if name in magnitudes and row.min <= 0 else row.start for name, row in table.items()]


@pytest.mark.slow
@pytest.mark.parametrize("fitted", [of_a_rider, of_a_mass])
def test_absent_effects_have_the_derivatives_of_a_simulation_of_all_states(fitted):
    again, from_last = simulated_again((case := fitted())[0])
    assert from_last
    held, states = set(), len(again.model.component.states)
    for effect in case[1]:
        model = again.model.with_added_effects(effect, slopes_of_base=False)
        table = {n: model.component.table[model.experiment.parameter(effect, n)] for n in effect.free_parameters()}
        q = np.concatenate([again.of_run(0)[: len(again.model.names)], absent(effect, table)])
        of_held, of_all = (
            (setattr(model, "found", dict(again.model.found)),
             model.slopes(*with_initial_guesses(again.runs, initial_guesses(again.runs)), q, from_last=last))[1]
            for last in (True, False)
        )  # fmt: skip
        # Slopes are those before the last step of Newton's method, which is at most `newton_method.CONVERGED` of the states.
        assert np.linalg.norm(of_held - of_all) < 1e-5 * np.linalg.norm(of_all) + 1e-9, effect
        held.add((model.states_without(model.values(q)), effect.has_states()))
    assert {(states, True), (states, False)} <= held


@pytest.mark.slow
def test_errors_of_values_from_a_single_block_are_not_zero():
    """The gradient of a fit vanishes over all samples, so that one block has none. Eight know an error to a quarter."""
    found, _ = of_a_mass()
    blocks = CommonBlocks(found, [], Criteria())
    samples = len(blocks.residuals(found).runs[0])
    errors = []
    for count in (1, 8):
        edges = np.linspace(0, samples, count + 1).astype(int)
        blocks.blocks = [(0, int(a), int(b)) for a, b in pairwise(edges)]
        errors.append(np.sqrt(np.diag(blocks.covariance(found))))
    np.testing.assert_allclose(errors[0], errors[1], rtol=1e-12)
