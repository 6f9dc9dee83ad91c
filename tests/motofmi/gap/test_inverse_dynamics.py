"""Starting values of a mechanism with two driven joints by inverse dynamics, on recordings of an unstable motion that a
controller holds."""

from dataclasses import replace

import numpy as np
import pytest

import motofmi as mf
from fmus.effects.damping import CoulombFriction
from fmus.effects.placement import by_name, laws_at
from motofmi.gap.comparison.search import single_effects
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.base_fit import fitted_base
from motofmi.gap.estimation.candidate import undetermined_magnitude
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.inverse_dynamics import imposed_motions, inverse_dynamics_fit
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import with_unknown_offsets
from tests.simulators.double_pendulum import SLIDING, TRUE, DoublePendulum, held_pendulum

# The only candidate: the equation error of all laws takes longer than the base.
FRICTION = [law for law in laws_at(DoublePendulum()) if law.form == "coulomb_elbow"]


def prepared(recording):
    experiment = input_output_experiment(DoublePendulum(), list(recording.columns))
    run = prepare_sampled_run(recording, experiment)
    experiment = with_unknown_offsets(experiment, [run])
    return experiment, [replace(run, experiment=experiment)]


def test_the_values_of_a_double_pendulum_are_found_without_a_simulation():
    experiment, runs = prepared(held_pendulum("run", seed=1, duration=6.0))
    model = FreeInitialStateModel(experiment)
    x, squares = inverse_dynamics_fit(model, imposed_motions(model, runs), model.start())
    # Within 1 %: noise of 0.2 mrad in the angles is the only error; the start values are 20 to 230 % off.
    assert {n: model.values(x)[n] for n in TRUE} == pytest.approx(TRUE, rel=0.01)
    assert squares < 1e-3 * runs[0].reduction_band * 6.0  # the required efforts are the recorded ones


def test_the_friction_of_a_joint_is_found_by_inverse_dynamics():
    experiment, runs = prepared(held_pendulum("run", seed=1, duration=9.0, friction=(0.0, 0.15)))
    model = FreeInitialStateModel(experiment)
    motions = imposed_motions(model, runs)
    alone = inverse_dynamics_fit(model, motions, model.start())[1]
    friction = type("Elbow", (CoulombFriction,), {"element": "elbow", "form": "elbow"})
    added = model.with_added_effects(friction)
    x, left = inverse_dynamics_fit(added, motions, added.start())
    name = experiment.parameter(friction, "friction_torque")
    # The transition of the simulated friction through zero rate is another one.
    assert added.values(x)[name] == pytest.approx(0.15, rel=0.05)
    assert left < 0.1 * alone


def test_the_slopes_of_the_required_efforts_are_their_differences():
    experiment, runs = prepared(held_pendulum("run", seed=1, duration=3.0))
    model = FreeInitialStateModel(experiment).with_added_effects(FRICTION[0])
    (motion,) = imposed_motions(model, runs)
    values = model.values(model.start()) | {experiment.parameter(FRICTION[0], "friction_torque"): 0.1}
    slopes = motion.slopes(model.equations, values)
    for place, name in enumerate(model.equations.parameters):
        step = 1e-5 * max(abs(values[name]), 0.1)
        either = [motion.residuals(model.equations, values | {name: values[name] + sign * step}) for sign in (1, -1)]
        # Central differences: the error is of the second order in a step of 1e-5.
        assert slopes[:, place] == pytest.approx((either[0] - either[1]) / (2 * step), rel=1e-5, abs=1e-6)


def test_one_degree_of_freedom_or_an_undriven_one_is_not_imposed():
    recording = held_pendulum("run", seed=1, duration=3.0)
    experiment, runs = prepared(recording)
    undriven = replace(recording, columns={n: x for n, x in recording.columns.items() if n != "elbow_torque"})
    for kept in (undriven, replace(recording, columns={n: recording[n] for n in ("torque", "elbow_torque", "angle")})):
        seen = input_output_experiment(DoublePendulum(), list(kept.columns))
        model = FreeInitialStateModel(seen)
        assert imposed_motions(model, [prepare_sampled_run(kept, seen)]) == []
    assert len(imposed_motions(FreeInitialStateModel(experiment), runs)) == 1


def test_the_base_of_an_unstable_mechanism_in_a_closed_loop():
    """Angles of more than 90 deg, at which the links fall within a segment of the recording without their controller."""
    experiment, runs = prepared(held_pendulum("run", seed=1, duration=6.0))
    found = fitted_base(experiment, runs, {}, FRICTION, Criteria()).fit
    values = found.model.values(found.shared)
    assert {n: values[n] for n in TRUE} == pytest.approx(TRUE, rel=0.005)  # 0.2 mrad of noise in 1,200 samples
    assert len(found.runs[0].segments) > 1
    assert found.reduced < 1.5  # noise alone is left


def test_the_base_keeps_the_offsets_of_its_sensors_from_one_fit_to_the_next():
    """Without them, the links fall within a segment."""
    run = held_pendulum("run", seed=2, duration=6.0)
    shifted = {"torque": run["torque"] - 0.3, "elbow_torque": run["elbow_torque"] + 0.2}
    experiment, runs = prepared(replace(run, columns=run.columns | shifted))
    found = fitted_base(experiment, runs, {}, FRICTION, Criteria()).fit
    values = found.model.values(found.shared)
    assert {n: values[n] for n in TRUE} == pytest.approx(TRUE, rel=0.005)  # 0.2 mrad of noise in 1,200 samples


@pytest.mark.slow
@pytest.mark.study
def test_the_friction_of_one_of_two_joints_is_named():
    runs = [held_pendulum(f"run_{seed}", seed, 9.0, friction=(0.0, 0.2)) for seed in (1, 2)]
    found = mf.find_gap(runs[0], validation=runs[1], component=DoublePendulum()).to_dict()
    assert [(e["name"], e["form"]) for e in found["effects"]] == [("coulomb_friction", "soft_elbow")]
    values = {n: p["value"] for n, p in found["effects"][0]["parameters"].items()}
    # The recordings are exact but for noise of 0.2 mrad.
    assert values == pytest.approx({"friction_torque": 0.2, "sliding_rate": SLIDING}, rel=0.01)


@pytest.mark.slow
@pytest.mark.study
def test_the_friction_of_both_joints_is_named_together():
    runs = [held_pendulum(f"run_{seed}", seed, 9.0, friction=(0.15, 0.2)) for seed in (1, 2)]
    found = mf.find_gap(runs[0], validation=runs[1], component=DoublePendulum()).to_dict()
    assert [(e["name"], e["element"]) for e in found["effects"]] == [("coulomb_friction", "shoulder and elbow")]
    values = {n: p["value"] for n, p in found["effects"][0]["parameters"].items()}
    expected = {"friction_torque_shoulder": 0.15, "friction_torque_elbow": 0.2, "sliding_rate": SLIDING}
    # The recordings are exact but for noise of 0.2 mrad.
    assert values == pytest.approx(expected, rel=0.01)


@pytest.mark.slow
def test_a_law_of_two_joints_is_fitted_from_its_linear_estimate_as_well():
    """By simulation, without starting values from inverse dynamics; the base compensates for most of the friction."""
    library = [law for law in laws_at(DoublePendulum()) if law.form.startswith("coulomb")]
    experiment, runs = prepared(held_pendulum("run", seed=1, duration=6.0, friction=(0.15, 0.2)))
    base = fitted_base(experiment, runs, {}, library, Criteria()).fit
    fits = {c.effect.form: c.fit.chi2 for c in single_effects(base, library, Criteria())}
    assert fits["coulomb_shoulder_and_elbow"] < 0.1 * min(fits["coulomb_shoulder"], fits["coulomb_elbow"])


@pytest.mark.parametrize(("torques", "absent"), [((0.1, 0.2), None), ((0.1, 0.0), "elbow"), ((0.0, 0.2), "shoulder")])
def test_a_law_of_two_joints_must_act_in_each(torques, absent):
    law = by_name(laws_at(DoublePendulum()))["coulomb_friction.coulomb_shoulder_and_elbow"]
    experiment, (run,) = prepared(held_pendulum("run", seed=1, duration=3.0))
    model = FreeInitialStateModel(experiment, [law])
    names = [f"friction_torque_{joint}" for joint in ("shoulder", "elbow")]
    start = model.start({experiment.parameter(law, n): x for n, x in zip(names, torques, strict=True)})
    deviations = np.zeros(2)  # of the sensor offsets of the run
    found = Fit(model, [run], np.append(start, deviations), 0.0, np.zeros(1), np.zeros((1, len(start) + 2)), 1)
    errors = np.full(len(start), 0.01)
    undetermined = undetermined_magnitude(found, errors, Criteria())
    assert (undetermined and undetermined[0]) == (absent and f"coulomb_friction.friction_torque_{absent}")
