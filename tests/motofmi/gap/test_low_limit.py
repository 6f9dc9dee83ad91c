"""A saturation of a torque that was recorded too large by a factor: its limit ends at its least share of the torque.

Below that share nearly all of the torque is beyond the limit, and the law is a factor on the torque.
"""

from dataclasses import replace

import numpy as np
import pytest

from fmus.effects.placement import laws_at
from fmus.mechanisms import DrivenJoint
from motofmi.gap.estimation.fitting import fit, shape_at_bound
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from tests.simulators.hidden_joint import JOINT, joint_run

FACTOR = 1.5  # of the recorded over the true torque


@pytest.mark.parametrize("level", [1e-3, 1e3])
def test_the_start_of_a_limit_is_within_its_bounds(level):
    """Without it a component with the law could not be made where the largest torque is more than ten times the start."""
    laws = [law for law in laws_at(DrivenJoint(), inputs={"torque": level}) if law.at_least_of_level]
    assert {law.form for law in laws} == {"clip_torque", "soft_torque"}
    for law in laws:
        assert law.declared["limit"].start >= law.declared["limit"].min == pytest.approx(0.1 * level)
        DrivenJoint().with_effects(law())


def test_a_saturation_that_is_a_factor_on_the_torque_ends_at_its_least_limit():
    run = joint_run({}, "random", seed=5, noise=1e-5, duration=8.0)
    run = replace(run, columns=run.columns | {"torque": FACTOR * run["torque"]})
    level = float(np.abs(run["torque"]).max())
    laws = laws_at(DrivenJoint(), inputs={"torque": level})
    (law,) = (law for law in laws if law.form == "clip_torque")
    assert law.declared["limit"].min == pytest.approx(0.1 * level)
    true = DrivenJoint().with_values(inertia=JOINT["J"], stiffness=JOINT["k"], damping=JOINT["c"])
    experiment = input_output_experiment(true, ["torque", "angle"])
    model = FreeInitialStateModel(experiment)
    prepared = [prepare_sampled_run(run, experiment)]
    base = fit(model, prepared, model.start())
    joined = model.with_added_effects(law)
    # The values of the joint are the true ones, so that only the law can reduce the torque.
    values = np.concatenate([model.start(), [1 - 1 / FACTOR, 0.3 * level]])
    found = fit(joined, base.runs, values, frozen=range(len(model.names)))
    assert shape_at_bound(found) == ("saturation.limit", "least")
