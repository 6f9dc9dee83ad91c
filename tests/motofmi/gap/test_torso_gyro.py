"""A rate gyro on the rider's torso: what it measures, what it parts, and that it says nothing where it is not."""

from dataclasses import replace

import numpy as np
import pytest

from motofmi.frequency_response.excitation import sweep as planned_sweep
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.experiment_design.detectable_effects import detectable_effects
from motofmi.gap.experiment_design.next_experiment import next_experiment
from motofmi.gap.experiment_design.planned_run import Channels, planned
from motofmi.gap.localisation.harmonic_places import cells
from motofmi.gap.localisation.locating import locate
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.validation.before_after import floor, misfit_of
from motofmi.recordings.channels import TORSO_RATE, UNITS
from motofmi.recordings.reading import read_recording, write_recording
from motofmi.recordings.recording import Recording
from motofmi.workflows.gap.rig import rig_effects, rig_experiment
from motofmi.workflows.gap.rig_proposals import rig_proposals

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from tests.simulators.hidden_rig import RIDER, Rig, record, sweep
from tests.simulators.rig_runs import RIG

USUAL = Rig()
COLUMNS = ("steer_angle_command", "steer_angle", "steer_torque", "torso_rate")
TRIO = ("cross_inertia", "steer_stiffness", "steer_damping")
LINEAR = [e for e in rig_effects() if e.family in TRIO]
UP, DOWN = sweep(0.5, 12, 2, 60.0), sweep(12, 0.5, 3.5, 60.0)


def recorded(hidden, excitation, seed, gyro=True, rig=USUAL):
    time, *columns = record(excitation, hidden, RIDER, np.random.default_rng(seed), rig)
    kept = COLUMNS if gyro else COLUMNS[:3]
    return Recording("run", time, dict(zip(kept, columns, strict=False)), {n: UNITS[n] for n in kept})


def made(*arguments, **options):
    return prepare_steer_test_run(
        recorded(*arguments, **options), "steer_angle", "steer_torque", "steer_angle_command", (TORSO_RATE,)
    )


@pytest.mark.slow
def test_the_model_meets_the_other_simulator():
    """Noise-free: the torso's rate by collocation at 128 Hz against RK4 at 1536 Hz, with coupled inertia and
    without."""
    for hidden, value in (({}, 0.0), ({"Icc": 0.05}, 0.05)):
        run = made(hidden, UP, 0, rig=Rig(angle_noise=1e-9, torque_noise=1e-9, remnant=1e-9, gyro_noise=1e-9, bits=20))
        effects = [e for e in LINEAR if e.family == "cross_inertia"] if value else []
        model = HarmonicModel(rig_experiment(RIG), effects)
        simulated = model.outputs(run, model.start({"device.cross_inertia.inertia": value}), slopes=False)[0]
        inside = np.concatenate([np.arange(first, last) for first, last, _ in run.reduction.bases])
        for i, output in enumerate(run.outputs):
            error = (simulated[:, i] - output.measured)[inside]
            # the steps of a converter of 20 bits and of the motion's splines are what is left
            assert np.sqrt(np.mean(error**2)) < 2e-3 * np.std(output.measured[inside])


@pytest.mark.slow
@pytest.mark.parametrize("family", ["", "cross_inertia", "channel_delay", "shaft_compliance", "hardening_stiffness"])
def test_slopes_are_those_of_differences(family):
    run = made({}, sweep(0.5, 12, 2, 40.0), 1)
    model = HarmonicModel(rig_experiment(RIG), [e for e in rig_effects() if e.family == family][:1])
    q = model.start()
    _, slopes = model.reduced(run, q)
    for i in range(len(q)):
        step = np.zeros(len(q))
        step[i] = 1e-3 * max(abs(q[i]), 1e-3)
        difference = (model.predicted(run, q + step) - model.predicted(run, q - step)) / (2 * step[i])
        # central differences with a step of 0.1 %: their own error is of the second order
        assert np.linalg.norm(difference - slopes[:, i]) < 1e-3 * np.linalg.norm(slopes[:, i]) + 1e-6


@pytest.mark.slow
def test_the_delay_of_the_torque_is_none_of_the_gyros():
    run = made({"td": 0.008}, UP, 2)
    model = HarmonicModel(rig_experiment(RIG), [e for e in rig_effects() if e.family == "channel_delay"])
    base = fit(HarmonicModel(rig_experiment(RIG)), [run], HarmonicModel(rig_experiment(RIG)).start())
    found = fit(model, [run], np.append(base.x[: len(model.base)], 0.003))
    assert parameters_of(found)["channel_delay.delay"][0] == pytest.approx(0.008, abs=2e-4)  # a fortieth of a sample
    assert found.reduced == pytest.approx(1.0, abs=0.15)  # 1084 numbers: 0.043 for one deviation, the noise estimated


@pytest.mark.study
def test_a_tie_is_settled_by_the_gyro_that_was_proposed():
    hidden, experiment = {"Icc": 0.08}, rig_experiment({})
    runs = [made(hidden, excitation, seed, gyro=False) for seed, excitation in ((3, UP), (4, DOWN))]
    verdict = select_model(HarmonicModel(experiment), runs, LINEAR)
    assert verdict.verdict == "tied" and "cross_inertia" in {c.family for c in verdict.tied}
    proposed = next_experiment(verdict, rig_proposals)
    gyro = next(a for a in proposed["alternatives"] if a["experiment"] == "torso_gyro")
    assert gyro["expected_delta_chi2"] > 40
    settings = gyro["settings"]
    more = made(
        hidden, sweep(settings["from"], settings["to"], np.degrees(settings["amplitude"]), settings["duration"]), 5
    )
    settled = select_model(HarmonicModel(experiment), [*runs, more], LINEAR)
    assert [c.family for c in settled.effects] == ["cross_inertia"]
    value, error, _ = parameters_of(settled.best)["device.cross_inertia.inertia"]
    assert abs(value - 0.08) < max(0.05 * 0.08, 2 * error)  # 5 % or two standard errors
    # what is left is shown in N.m: the gyro's share is not in it
    assert misfit_of(settled.best).rms == pytest.approx(floor(settled.best.runs), rel=0.1)
    assert "torso_gyro" not in {p.experiment for p in rig_proposals(settled.best)}


@pytest.mark.slow
def test_the_plan_predicts_which_effects_a_gyro_distinguishes():
    experiment = rig_experiment({**RIG, "noise": {TORSO_RATE: 0.02}})
    model, found = HarmonicModel(experiment), {}
    for further in ({}, {TORSO_RATE: experiment.further[TORSO_RATE].noise}):
        channels = Channels(128.0, float(np.radians(0.03)), lambda f: 0.04 + 0 * f, further)
        run = planned(
            planned_sweep(0.5, 12.0, 60.0, np.radians(2)),
            channels,
            experiment.columns,
            lambda r: model.outputs(r, model.start(), slopes=False)[0],
        )
        found[bool(further)] = {
            n.effect.family: n for n in detectable_effects(fit(model, [run], model.start()), LINEAR)
        }
    assert found[False]["steer_stiffness"].tied
    assert all(n.named is not None and not n.tied for n in found[True].values())
    assert run.outputs[1].noise(10.0) == pytest.approx(0.02**2, rel=0.1)  # of 400 numbers or more about 10 Hz: 0.07


@pytest.mark.slow
def test_without_the_column_nothing_changes():
    with_, without = (made({"Tc": 0.3}, UP, 6, gyro=gyro) for gyro in (True, False))
    assert np.array_equal(with_.effort.data, without.effort.data) and np.array_equal(
        with_.effort.deviation, without.deviation
    )
    model = HarmonicModel(rig_experiment(RIG))
    alone = [fit(model, [run], model.start()) for run in (without, replace(with_, outputs=with_.outputs[:1]))]
    assert alone[0].chi2 == alone[1].chi2
    assert {p.axis for p in locate(alone[0], cells)} <= {"run", "order", "frequency", "time", "amplitude", "direction"}
    both = locate(fit(model, [made({"Icc": 0.05}, UP, 6)], model.start()), cells)
    assert any(p.axis.startswith("torso_rate over ") for p in both)


@pytest.mark.slow
def test_errors_of_the_gain_are_whitened_with_the_noise():
    output = made({}, sweep(0.5, 12, 2, 30.0), 9).outputs[1]
    y = output.data
    covariance = np.diag(output.deviation**2) + output.gain_error**2 * np.outer(y, y)
    one_side = output.over_noise(covariance)
    assert output.over_noise(one_side.T) == pytest.approx(np.eye(len(y)), abs=1e-6)  # of entries up to 1e3


@pytest.mark.slow
@pytest.mark.parametrize("gain", [0.98, 1.01])
def test_a_gyro_that_is_a_little_wrong_is_no_gap(gain):
    recording = recorded({}, UP, 10)
    recording.columns[TORSO_RATE][:] *= gain
    model = HarmonicModel(rig_experiment(RIG))
    found = fit(
        model,
        [prepare_steer_test_run(recording, "steer_angle", "steer_torque", "steer_angle_command", (TORSO_RATE,))],
        model.start(),
    )
    assert found.reduced == pytest.approx(1.0, abs=0.2)  # 600 numbers: 0.06 for one deviation, the noise estimated


@pytest.mark.slow
def test_a_dead_gyro_is_not_compared(tmp_path):
    recording = recorded({}, sweep(0.5, 12, 2, 30.0), 8)
    recording.columns[TORSO_RATE][:] = 0.0
    write_recording(recording, tmp_path / "run.csv")
    read = read_recording(tmp_path / "run.csv")
    assert (
        len(prepare_steer_test_run(read, "steer_angle", "steer_torque", "steer_angle_command", (TORSO_RATE,)).outputs)
        == 1
    )
    assert "torso_rate is constant at 0 rad/s" in read.warnings


@pytest.mark.slow
def test_the_rigs_noise_is_read(tmp_path):
    (tmp_path / "rig.json").write_text('{"noise": {"torso_rate": {"value": 2.0, "unit": "deg/s"}}}')
    write_recording(recorded({}, sweep(0.5, 12, 2, 30.0), 7), tmp_path / "run.csv")
    recording = read_recording(tmp_path / "run.csv")
    assert rig_experiment(recording.rig).further[TORSO_RATE].noise == pytest.approx(np.radians(2.0))
    assert recording.units[TORSO_RATE] == "rad/s"
