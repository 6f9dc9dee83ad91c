"""Runs of a component sample by sample: the inputs between the samples, the noise, initial states, and fits that share nothing."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import butter, lfilter

from fmus.effects.placement import laws_at
from fmus.mechanisms import DrivenJoint, MassSpringDamper
from fmus.support.errors import InputError
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.initial_fit import initial_fit
from motofmi.gap.experiment_design.scaled_runs import scaled_runs
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.free_initial_state import FreeInitialStateModel
from motofmi.gap.preprocessing.blocks import blocks_of
from motofmi.gap.preprocessing.compared_samples import at_limits
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.candidate_search import search_candidates
from motofmi.gap.selection.noise_rounds import with_noise_of_best_effect
from motofmi.recordings.recording import Recording
from motofmi.recordings.resampling import white_noise
from tests.simulators.hidden_joint import joint_run


def test_cosines_of_blocks_are_orthonormal():
    blocks = blocks_of([(0, 700), (700, 1000)], 2, 100.0, 50.0)
    y = np.random.default_rng(0).standard_normal((1000, 2))
    assert np.linalg.norm(blocks.reduce(y)) == pytest.approx(np.linalg.norm(y), rel=1e-12)
    assert len(blocks.columns) == len(blocks.reduce(y))
    assert blocks.reduce_segments(y[None, 700:], [1])[0] == pytest.approx(blocks.reduce(y)[-600:])


def test_slopes_of_the_reduced_output_with_the_initial_states_taken_out():
    run_ = joint_run({}, duration=6.0)
    test = input_output_experiment(DrivenJoint(inertia=0.09, stiffness=13.0, damping=0.15), list(run_.columns))
    run, model = prepare_sampled_run(run_, test), FreeInitialStateModel(test)
    q = model.start()
    z, slopes = model.reduced(run, q)
    residual = z - run.data / run.deviation
    for i in range(len(q)):
        step = np.eye(len(q))[i] * 1e-5
        up, down = (model.reduced(run, q + s)[0] - run.data / run.deviation for s in (step, -step))
        # Variable projection gives the slope of chi-square exactly, that of single residuals but for second-order terms
        assert 2 * residual @ slopes[:, i] == pytest.approx((up @ up - down @ down) / 2e-5, rel=1e-3, abs=1.0)


def test_slopes_alone_are_those_of_the_reduced_output_without_further_simulations(monkeypatch):
    run_ = joint_run({}, duration=6.0)
    test = input_output_experiment(DrivenJoint(inertia=0.09, stiffness=13.0, damping=0.15), list(run_.columns))
    run, base = prepare_sampled_run(run_, test), FreeInitialStateModel(test)
    base.reduced(run, base.start())  # its initial states are known from here on
    coulomb = next(e for e in laws_at(test.component) if e.form == "coulomb")
    model = base.with_added_effects(coulomb)
    q = np.append(base.start(), np.zeros(len(model.names) - len(base.names)))
    searched = model.reduced(run.with_initial_guesses(run.guess), q)[1]

    def no_search(*_):
        raise AssertionError("initial states were searched for")

    simulations = []
    simulated = FreeInitialStateModel.simulated
    monkeypatch.setattr(FreeInitialStateModel, "simulated", lambda *given, **options: simulations.append(1) or simulated(*given, **options))
    monkeypatch.setattr(FreeInitialStateModel, "_extended", no_search)
    alone = model.slopes(run.with_initial_guesses(run.guess), q)
    assert len(simulations) == 1  # of all segments together
    # The search changes the initial states by less than 1e-3 of their effect on the slopes.
    assert alone == pytest.approx(searched, abs=1e-3 * np.abs(searched).max())


def one_segment(run, index):
    """The run with one of its segments only, and the initial guess of that one."""
    whole, rows = run.reduction, run.reduction.rows[index]
    spans = [span for span, owner in zip(whole.spans, whole.segment_of, strict=True) if owner == index]
    reduction = replace(whole, spans=spans, segment_of=[0] * len(spans), columns=[whole.columns[i] for i in rows])
    return replace(run, segments=[run.segments[index]], reduction=reduction, data=run.data[rows],
                   deviation=run.deviation[rows], guess={0: dict(run.guess[index])})  # fmt: skip


@pytest.mark.slow
def test_segments_together_are_what_each_is_alone():
    """One trajectory with breaks: outputs and slopes, of a hysteresis and of a linear joint whose matrices do not
    change over time."""
    sampled = prepare_sampled_run(
        joint_run({}, "random", seed=5, duration=18.0), input_output_experiment(DrivenJoint(), ["torque", "angle"])
    )
    laws = {e.form: e for e in laws_at(sampled.experiment.component)}
    FreeInitialStateModel(sampled.experiment).reduced(
        sampled, FreeInitialStateModel(sampled.experiment).start()
    )  # initial states for all that follows
    for effects, own in (([], []), ([laws["dahl"]], [0.2, 0.05]), ([laws["delay"]], [0.004])):
        model = FreeInitialStateModel(sampled.experiment, effects)
        q = np.concatenate([model.start()[: len(model.base)], own])
        together = model.reduced(sampled.with_initial_guesses(sampled.guess), q)
        alone = [model.reduced(one_segment(sampled, i), q) for i in range(len(sampled.segments))]
        assert len(sampled.segments) > 3
        # The initial states of either are known to a share of 1e-5 of what is left
        assert together[0] == pytest.approx(np.concatenate([output for output, _ in alone]), abs=0.02)
        scale = np.abs(together[1]).max(axis=0)
        assert together[1] / scale == pytest.approx(np.concatenate([slopes for _, slopes in alone]) / scale, abs=1e-3)


@pytest.mark.study
def test_a_spring_that_stiffens_much_is_simulated_as_a_variable_step_solver_does():
    """All segments at once do not converge from nowhere, and what they come to then was taken for the answer, a million
    times too large."""
    rng, (mass, damping, stiffness, cubic) = np.random.default_rng(2), (1.1, 1.2, 300.0, 1e5)
    a, w, p = rng.normal(0, 0.8, 60), 2 * np.pi * rng.uniform(0.2, 12, 60), rng.uniform(0, 6, 60)

    def force(t):
        return np.cos(np.multiply.outer(t, w) + p) @ a

    time = np.arange(0, 60, 0.005)
    exact = solve_ivp(
        lambda t, y: [y[1], (force(t) - damping * y[1] - stiffness * y[0] - cubic * y[0] ** 3) / mass],
        (0, 60),
        [0, 0],
        t_eval=time,
        rtol=1e-9,
        atol=1e-11,
    ).y[0]
    values = {"mass": mass, "spring_damping": damping, "spring_stiffness": stiffness}
    recording = Recording(
        "random", time, {"force": force(time), "displacement": exact}, {"force": "N", "displacement": "m"}
    )
    run = prepare_sampled_run(
        recording, input_output_experiment(MassSpringDamper().with_values(**values), list(recording.columns))
    )
    law = next(e for e in laws_at(run.experiment.component) if e.form == "cubic" and e.family == "hardening_stiffness")
    model = FreeInitialStateModel(run.experiment, [law])
    q = model.start()
    q[model.names.index("hardening_stiffness.cubic_stiffness")] = cubic
    assert 3 * cubic * np.var(exact) > 0.3 * stiffness  # it is so much stiffer in the mean
    left = model.residuals_and_motion(run, q)[0]
    # What is not known of the force between its samples is a thousandth.
    assert np.std(left) < 2e-3 * np.std(exact)


def test_inputs_interpolated_at_other_times_are_not_reused():
    run = prepare_sampled_run(
        joint_run({}, "random", seed=5, duration=6.0), input_output_experiment(DrivenJoint(), ["torque", "angle"])
    )
    one, other = np.array([1.0, 2.0, 4.0]), np.array([1.0, 3.0, 4.0])  # as many, with the same ends
    assert run.inputs(one)["torque"][1] != run.inputs(other)["torque"][1]


@pytest.mark.study
def test_noise_is_taken_beside_the_next_fit_where_the_best_can_be_simulated_from_nowhere_else(monkeypatch):
    t = np.arange(0, 10, 0.01)
    rng = np.random.default_rng(6)
    columns = {"torque": np.sin(7 * t), "angle": 0.05 * np.sin(7 * t + 0.3) + 1e-4 * rng.standard_normal(len(t))}
    test = input_output_experiment(DrivenJoint(inertia=0.1, stiffness=10.0, damping=0.1), list(columns))
    run = prepare_sampled_run(Recording("run", t, columns, {"torque": "N.m", "angle": "rad"}), test)
    base = initial_fit(FreeInitialStateModel(test), [run])
    beside = FreeInitialStateModel.with_remaining_noise

    def only_the_base(model, run, q):
        if model.effects:
            raise InputError("the simulation diverges")
        return beside(model, run, q)

    monkeypatch.setattr(FreeInitialStateModel, "with_remaining_noise", only_the_base)
    known = []
    with_noise = with_noise_of_best_effect(
        base, laws_at(test.component, 0.35, {"torque": 1.0}, {"angle": 0.05}), known
    )
    assert [r.name for r in with_noise] == ["run"] and all(k.model.effects for k in known)


@pytest.mark.slow
def test_noise_does_not_make_a_motion_faster():
    motion = prepare_sampled_run(
        joint_run({}, "random", seed=1), input_output_experiment(DrivenJoint(), ["torque", "angle"])
    )
    noisy = prepare_sampled_run(
        joint_run({}, "random", seed=1, noise=0.03), input_output_experiment(DrivenJoint(), ["torque", "angle"])
    )
    assert noisy.middle_frequency == pytest.approx(motion.middle_frequency, rel=0.1)


def test_a_fit_leaves_no_trace_in_the_runs_that_it_was_given():
    run = joint_run({}, "random", seed=5, duration=6.0)
    test = input_output_experiment(DrivenJoint(), list(run.columns))
    sampled, model = prepare_sampled_run(run, test), FreeInitialStateModel(test)
    found = fit(model, [sampled], model.start())
    assert not sampled.guess and (0,) in found.runs[0].guess


@pytest.mark.study
def test_many_processes_find_what_one_does(monkeypatch):
    run = joint_run({"hardening": 40.0}, "random", seed=5)
    test = input_output_experiment(DrivenJoint(), list(run.columns))
    library = [e for e in laws_at(test.component, 0.35) if e.family in ("hardening_stiffness", "asymmetry", "drift")]
    found = {}
    for processes in ("1", "2"):
        monkeypatch.setenv("OMP_NUM_THREADS", processes)
        base = initial_fit(FreeInitialStateModel(test), [prepare_sampled_run(run, test)])
        candidates = search_candidates(base, library)
        best, (sampled,) = candidates[0].fit, candidates[0].fit.runs
        found[processes] = [(c.effect.form, c.fit.chi2) for c in candidates if c.fitted]
        # Whatever process found it, its runs know from where they are simulated with this effect
        assert {(*best.model.own, i) for i in range(len(sampled.segments))} <= set(sampled.guess)
        again = best.model.reduced(sampled, best.shared)[0]
        assert np.sum((again - sampled.data / sampled.deviation) ** 2) == pytest.approx(best.chi2, rel=1e-3)
    assert [form for form, _ in found["1"]] == [form for form, _ in found["2"]]
    assert [chi2 for _, chi2 in found["1"]] == pytest.approx([chi2 for _, chi2 in found["2"]], rel=1e-9)


def swing(rate, duration=12.0, noise=1e-4, seed=0):
    """A pendulum's free swing of 0.7 Hz: angle [rad] alone."""
    time = np.arange(0, duration, 1 / rate)
    angle = 0.4 * np.exp(-0.05 * time) * np.cos(2 * np.pi * 0.7 * time)
    angle = angle + noise * np.random.default_rng(seed).standard_normal(len(time))
    return Recording("swing", time, {"angle": angle}, {"angle": "rad"})


@pytest.mark.parametrize("rate", [50.0, 500.0])
def test_segments_do_not_depend_on_the_sampling_rate(rate):
    recording = swing(rate)
    run = prepare_sampled_run(recording, input_output_experiment(DrivenJoint(), ["angle"]))
    # Hann's window is two lines of 1 / 12 Hz wide to each side
    assert run.middle_frequency == pytest.approx(0.7, abs=0.05)
    assert len(run.segments) == 1  # six periods are 8.6 s of 12


@pytest.mark.parametrize(("returns", "left_out"), [(False, 0), (True, 1)])
def test_a_steady_value_is_no_limit_of_a_sensor_unless_the_motion_returns_from_it(returns, left_out):
    """Steps of a torque to which a coarse sensor responds with values that stay; and the same clipped during one of
    them."""
    time = np.arange(0, 12, 0.01)
    torque = np.where(time < 4, 0.0, np.where(time < 8, 1.0, 0.3))
    angle = np.interp(time, [4, 4.5, 8, 8.5], [0, 1, 1, 0.3])
    if returns:
        angle = np.minimum(angle + 0.5 * np.sin(2 * np.pi * 0.3 * (time - 4)) * ((time > 4) & (time < 6.5)), 1.0)
        angle -= 0.2 * np.clip(time - 5.5, 0, 1) * (time < 8)
    recording = Recording("steps", time, {"angle": np.round(angle, 2), "torque": torque}, {"angle": "rad", "torque": "N.m"})
    limits, notes = at_limits(recording, input_output_experiment(DrivenJoint(), ["angle", "torque"]))
    assert len(notes) == left_out == len(limits)


def test_bridged_and_clipped_samples_are_not_compared():
    """The same residual at samples that are left out changes nothing."""
    whole = swing(50.0, 20.0)
    held = np.clip(whole["angle"], -0.3, 0.3)
    held[[100, 101]] = np.nan
    kept = np.isfinite(held)
    recording = Recording("clipped", whole.time[kept], {"angle": held[kept]}, whole.units)
    run = prepare_sampled_run(recording, input_output_experiment(DrivenJoint(), ["angle"]))
    at_limit = np.isin(held, [-0.3, 0.3])
    assert np.array_equal(~run.reduction.compared[:, 0], at_limit | ~kept)
    assert sum("at its limit of" in note for note in run.notes) == 2
    assert len(run.segments) == 1 or all(b[0] == a[1] for a, b in zip(run.segments, run.segments[1:], strict=False))
    off = whole["angle"][:, None] + 5.0 * ~run.reduction.compared
    assert run.reduction.reduce(off) == pytest.approx(run.data, abs=1e-9)


def test_a_smooth_record_is_an_excitation_at_any_bandwidth():
    """Full up to four fifths of half the sampling rate, its fourth differences are as large as the signal."""
    y = lfilter(*butter(8, 0.8), np.random.default_rng(4).standard_normal(3000))
    assert np.std(y) < 5 * white_noise(y)  # what was taken for "no excitation"
    recording = Recording("wide", np.arange(3000) / 100, {"angle": y}, {"angle": "rad"})
    assert prepare_sampled_run(recording, input_output_experiment(DrivenJoint(), ["angle"])).data.any()


def test_a_run_of_another_excitation_has_it_in_every_interpolation():
    run = prepare_sampled_run(joint_run({}), input_output_experiment(DrivenJoint(), ["torque", "angle"]))
    time = run.recording.time[10:20] + 0.003
    for kind in ("smooth", "lines", "held"):
        once, twice = (each.with_interpolation(kind).inputs(time)["torque"] for each in (run, run.scaled(2.0)))
        assert twice == pytest.approx(2 * once)


@pytest.mark.parametrize(("torque", "proposed"), [(0.0, False), (1.0, True)])
def test_a_free_decay_is_not_repeated_with_another_excitation(torque, proposed):
    run = joint_run({}, start=(0.3, 0.0))
    run.columns["torque"] *= torque
    prepared = prepare_sampled_run(run, input_output_experiment(DrivenJoint(), ["torque", "angle"]))
    assert bool(scaled_runs(SimpleNamespace(runs=[prepared]))) == proposed
