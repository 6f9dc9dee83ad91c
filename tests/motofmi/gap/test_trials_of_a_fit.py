"""The trials of a fit whose unknown initial states are eliminated: what is simulated, and what is searched for again."""

import numpy as np
import pytest

from fmus.effects.placement import laws_at
from fmus.mechanisms import DrivenJoint
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models import segmented
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from tests.simulators.hidden_joint import joint_run


def joint(duration=6.0):
    """A run of a driven joint without a hidden effect, and the model of its base."""
    recording = joint_run({}, duration=duration)
    test = input_output_experiment(DrivenJoint(), list(recording.columns))
    return prepare_sampled_run(recording, test), FreeInitialStateModel(test)


def test_a_trial_of_a_fit_does_not_search_for_initial_states_again(monkeypatch):
    run, model = joint()
    known = fit(model, [run], model.start()).of_run(0)
    far = known + np.log(4.0) * np.array([name == "stiffness" for name in model.names])  # another resonance
    searched, extended = [], FreeInitialStateModel._extended
    monkeypatch.setattr(
        FreeInitialStateModel,
        "_extended",
        lambda *given, **options: searched.extend(given[2]) or extended(*given, **options),
    )
    model.reduced(run, known)
    before = len(searched)  # its segments, none of which has been simulated
    trial = model.trial(run, far, model.simulated_once(run, far))[0]
    assert before and len(searched) == before
    again = model.reduced(run, far)[0]
    assert len(searched) > before
    measured = run.data / run.deviation
    # Gauss and Newton's method from the last initial states finds the same ones here
    assert np.sum((trial - measured) ** 2) == pytest.approx(np.sum((again - measured) ** 2), rel=1e-3)


@pytest.mark.parametrize(("effect", "share"), [(None, 1e-9), ("hardening_stiffness", 1e-3)])
def test_one_simulation_gives_the_residuals_after_the_search_to_first_order(monkeypatch, effect, share):
    run, base = joint()
    effects = [e for e in laws_at(base.component) if (e.family, e.form) == (effect, "cubic")]
    model = base.with_added_effects(*effects)
    known = np.append(fit(base, [run], base.start()).of_run(0), [20.0] * len(effects))
    model.reduced(run, known)
    near = known + 0.02
    simulations, simulated = [], FreeInitialStateModel.simulated
    monkeypatch.setattr(FreeInitialStateModel, "simulated", lambda *given, **options: simulations.append(1) or simulated(*given, **options))
    begun = model.simulated_once(run, near)
    assert len(simulations) == 1  # of all segments together
    first = np.concatenate([segment.reduced for segment in begun.values()])
    after = model.trial(run, near, begun)[0] - run.data / run.deviation
    # A linear component: roundings, and the step of Newton's method at its end; otherwise what is of second order in the
    # change of the initial states by 2 % of the parameters.
    assert np.sum(first**2) == pytest.approx(np.sum(after**2), rel=share)


def test_initial_states_are_refined_in_those_trials_only_that_may_be_accepted(monkeypatch):
    run, model = joint()
    measured, once, refined = run.data / run.deviation, [], []
    simulated_once, trial = FreeInitialStateModel.simulated_once, FreeInitialStateModel.trial

    def noted_once(*given):
        begun = simulated_once(*given)
        once.append(sum(np.sum(segment.reduced**2) for segment in begun.values()))
        return begun

    def noted_trial(*given):
        found = trial(*given)
        refined.append((once[-1], np.sum((found[0] - measured) ** 2)))
        return found

    monkeypatch.setattr(FreeInitialStateModel, "simulated_once", noted_once)
    monkeypatch.setattr(FreeInitialStateModel, "trial", noted_trial)
    far = model.start() + np.log(3.0) * np.array([name == "stiffness" for name in model.names])  # another resonance
    found = fit(model, [run], far)
    assert 0 < len(refined) < len(once)
    # No trial was refined that was worse to first order than the one accepted before it, without the prior's share.
    least = np.minimum.accumulate([np.inf, *(after for _, after in refined)])
    assert all(first < before for (first, _), before in zip(refined[1:], least[1:], strict=False))
    assert found.chi2 == pytest.approx(fit(model, [run], model.start()).chi2, rel=1e-3)  # the same minimum


def test_the_next_simulation_begins_at_the_predicted_states(monkeypatch):
    run, model = joint()
    known = fit(model, [run], model.start()).of_run(0)
    model.reduced(run, known)
    far = known + np.log(4.0) * np.array([name == "stiffness" for name in model.names])
    deviations, simulate = [], segmented.simulate

    def noted(equations, values, motion, start, *given, **options):
        made = simulate(equations, values, motion, start, *given, **options)
        deviations.append(np.abs(start - made.states).max() / np.abs(made.states).max())
        return made

    monkeypatch.setattr(segmented, "simulate", noted)
    model.trial(run, far, model.simulated_once(run, far))
    # The first guess has the states of another stiffness. After a change of the initial states alone the prediction is
    # exact, since the component is linear.
    assert len(deviations) > 1 and deviations[0] > 1e-2 and max(deviations[1:]) < 1e-9


def test_segments_that_are_simulated_as_a_whole_are_not_simulated_piece_by_piece(monkeypatch):
    """With inaccurate values of a hysteresis and of friction their initial states are estimated again. Simulating their
    first samples piece by piece, down to single steps, took 6 s."""
    run, base = joint(20.0)
    known = fit(base, [run], base.start()).of_run(0)
    forms = (("hysteresis", "dahl"), ("coulomb_friction", "soft"))
    effects = [e for form in forms for e in laws_at(base.component) if (e.family, e.form) == form]
    model = base.with_added_effects(*effects)
    model.reduced(run, np.append(known, [1e-4, 0.004, 1e-4, 0.02]))  # N.m, rad, N.m, rad/s
    simulations, simulated = [], segmented.simulate
    monkeypatch.setattr(segmented, "simulate", lambda *given, **o: simulations.append(1) or simulated(*given, **o))
    model.reduced(run, np.append(known, [0.17, 0.004, 0.3, 0.02]))
    assert len(simulations) < 50  # 20; with pieces 198
