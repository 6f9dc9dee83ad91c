"""The comparison on blocks where a model cannot be simulated on the validation runs."""

import pytest

from fmus.effects.damping import CoulombFriction
from fmus.mechanisms import DrivenJoint
from fmus.support.errors import InputError
from motofmi.gap.comparison import compared_model
from motofmi.gap.comparison.compared_model import on_validation_runs
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import investigate
from motofmi.workflows.components import laws_at
from tests.simulators.hidden_joint import joint_run


@pytest.mark.slow
def test_the_leading_effect_may_diverge_on_validation_runs(monkeypatch):
    """The base misses friction, and backlash that is not among the candidates: models are compared on blocks."""

    def diverging(found, runs, criteria):
        if any(effect.family == CoulombFriction.family for effect in found.model.effects):
            raise InputError("the simulation of validation diverges")
        return on_validation_runs(found, runs, criteria)

    monkeypatch.setattr(compared_model, "on_validation_runs", diverging)
    hidden = {"friction": 0.6, "backlash": 0.02}
    experiment = input_output_experiment(DrivenJoint(), ["torque", "angle"])
    library = [effect for effect in laws_at(DrivenJoint()) if effect.form in ("coulomb", "cubic")]
    fitted, held = (joint_run(hidden, seed=seed, noise=1e-5, duration=8.0) for seed in (1, 2))
    verdict = investigate(experiment, [prepare_sampled_run(fitted, experiment)], validation=[held], library=library).verdict
    assert verdict.comparison is not None
    assert verdict.comparison.outcome.disagreement == ""  # both runs are of one joint
    assert all(c.family != "coulomb_friction" for c in (*verdict.effects, *verdict.tied))
