"""The search on a validation run: how many starts the offset of a sensor has, and that initial states are kept."""

import pytest

from fmus.effects.damping import CoulombFriction
from fmus.effects.stiffness import CubicHardening
from fmus.mechanisms import DrivenJoint
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.validation import before_after
from tests.simulators.hidden_joint import joint_run


def fitted(law):
    """A joint with an effect and an offset of the torque's sensor, and the run that is also the validation run."""
    recording = joint_run({}, duration=6.0)
    component = DrivenJoint(inertia=0.09, stiffness=13.0, damping=0.15)
    experiment = input_output_experiment(component, list(recording.columns)).with_sensor_offsets({"torque": 0.3})
    run = prepare_sampled_run(recording, experiment)
    model = FreeInitialStateModel(experiment, [law])
    return fit(model, [run], model.start(), iterations=0), run


@pytest.mark.parametrize(("law", "several"), [(CoulombFriction, False), (CubicHardening, True)])
def test_only_a_law_of_the_deflection_has_several_starts_of_an_offset(monkeypatch, law, several):
    """Over an offset of the torque a hardening spring has several minima, dry friction has one."""
    found, run = fitted(law)
    starts = []

    def counted(model, runs, start, **options):
        starts.append(start)
        return fit(model, runs, start, **options)

    monkeypatch.setattr(before_after, "fit", counted)
    before_after.on_validation_runs(found, [run])
    assert (len(starts) > 1) == several


def test_the_noise_on_validation_runs_is_taken_from_the_initial_states_that_were_found(monkeypatch):
    """A new search may fail where the one of the fit did not."""
    found, run = fitted(CoulombFriction)
    original, known = FreeInitialStateModel.with_remaining_noise, []

    def seen(model, run, q):
        known.append(bool(run.guess))
        return original(model, run, q)

    monkeypatch.setattr(FreeInitialStateModel, "with_remaining_noise", seen)
    before_after.before_and_after(found, found, [run.with_initial_guesses({})])
    assert known == [True]
