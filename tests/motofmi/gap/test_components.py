"""The gap workflow on components that are no rig of ours, with data from scipy's solvers and equations of their own."""

import json
import re

import numpy as np
import pytest

from fmus.composition.added_force import WithAddedForce
from fmus.declaration.variables import parameter
from fmus.effects.placement import laws_at
from fmus.mechanisms import DrivenJoint, MassSpringDamper, Pendulum, TwoMass, mechanisms
from motofmi.cli.main import main
from motofmi.gap.alternatives import reason
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.unit_plausibility import common_factor, parameters_with_force_or_mass
from motofmi.gap.experiment_design.next_experiment import next_experiment
from motofmi.gap.experiment_design.scaled_runs import scaled_runs
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.selection.any_component import investigate
from motofmi.recordings.reading import write_recording
from motofmi.recordings.recording import Recording
from motofmi.reports.gap_component import left_over, pictures
from motofmi.workflows import components
from tests import as_study
from tests.simulators.hidden_joint import JOINT, joint_run
from tests.simulators.hidden_mechanisms import excitation, resistance, simulate, torque_for


def asked(component, recordings, **more):
    test = input_output_experiment(component, list(recordings[0].columns), **more)
    return investigate(test, [prepare_sampled_run(r, test) for r in recordings]).verdict


# Parts --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["mass_spring_damper", "driven_joint", "pendulum", "two_mass"])
def test_every_mechanism_is_found_by_its_name_with_laws_that_act(name):
    component = components.component(name)
    families = {e.family for e in laws_at(component)}
    assert {
        "coulomb_friction",
        "hardening_stiffness",
        "backlash",
        "hysteresis",
        "drift",
        "extra_mode",
        "channel_delay",
        "saturation",
    } <= families
    assert ("geometric_nonlinearity" in families) == (name in ("driven_joint", "pendulum"))
    assert name in mechanisms.names()
    keys = [(e.family, e.form) for e in laws_at(component)]
    assert len(set(keys)) == len(keys)
    assert {f"clip_{component.inputs[0]}", f"soft_{component.inputs[0]}"} <= {
        form for family, form in keys if family == "saturation"
    }


def test_an_actuator_that_clips_and_a_sensor_that_bends():
    (clip,) = (e for e in laws_at(MassSpringDamper(), inputs={"force": 8.0}) if e.form == "clip_force")
    assert clip.starts["limit"] == (2.4, 4.0, 5.6, 6.8)
    clipped = MassSpringDamper().with_effects(clip()).with_values(**{"saturation.limit": 2.0, "saturation.share": 1.0})
    assert clipped.table["saturation.limit"].unit == "N"
    for force, arrives in ((1.5, 1.5), (5.0, 2.0), (-9.0, -2.0)):
        rates, _ = clipped.derivatives(np.zeros(2), np.array([force]))
        assert rates == pytest.approx([0.0, arrives])  # m = 1
    nonlinear = {
        e.form: e
        for e in laws_at(MassSpringDamper(), outputs={"displacement": 0.2})
        if e.family == "sensor_nonlinearity"
    }
    cubic = (
        MassSpringDamper()
        .with_effects(nonlinear["cubic_displacement"]())
        .with_values(**{"sensor_nonlinearity.cubic_gain": 0.5})
    )
    assert cubic.table["sensor_nonlinearity.reference"].unit == "m"
    rates, outputs = cubic.derivatives(np.array([0.1, 3.0]), np.zeros(1))
    assert dict(zip(cubic.outputs, outputs, strict=True)) == pytest.approx(  # what is shown; the spring feels 0.1
        {"displacement": 0.1, "velocity": 3.0, "displacement_shown": 0.1 * (1 + 0.5 * 0.25)}
    )
    assert rates == pytest.approx([3.0, -400 * 0.1 - 2 * 3.0])


def test_friction_may_act_at_drive_and_load():
    forms = {e.form for e in laws_at(TwoMass()) if e.family == "coulomb_friction"}
    assert {"coulomb", "coulomb_drive", "coulomb_load"} <= forms


def test_a_component_without_elements_gets_a_place_for_laws():
    with_force = WithAddedForce(MassSpringDamper(), "force", "displacement", "velocity")
    hardening = next(e for e in laws_at(with_force) if (e.family, e.form) == ("hardening_stiffness", "cubic"))
    joined = with_force.with_effects(hardening()).with_values(**{"hardening_stiffness.cubic_stiffness": 7.0})
    rates, _ = joined.derivatives(np.array([0.5, 2.0]), np.array([3.0]))
    # m v' = F - k x - c v - k3 x^3 with the defaults m = 1, k = 400, c = 2
    assert rates == pytest.approx([2.0, 3.0 - 200.0 - 4.0 - 7.0 * 0.125])


# Verdicts -----------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.study
@pytest.mark.parametrize(("hidden", "kind", "component", "family"), [
    ({"friction": 0.3}, "multisine", DrivenJoint(), "coulomb_friction"),
    ({"hardening": 40.0}, "random", DrivenJoint(), "hardening_stiffness"),
    ({"hysteresis": (0.8, 0.03)}, "chirp", DrivenJoint(), "hysteresis"),
    ({"sine": 1.0}, "decay", Pendulum(), "geometric_nonlinearity"),
    ({"clip": 2.5}, "random", DrivenJoint(), "saturation"),
    ({"sensor": 0.2}, "multisine", DrivenJoint(), "sensor_nonlinearity"),
])  # fmt: skip
def test_a_hidden_effect_is_named(hidden, kind, component, family):
    start, duration = ((1.2, 0.0), 10.0) if kind == "decay" else ((0.0, 0.0), 6.0)
    verdict = asked(component, [joint_run(hidden, kind, seed=5, duration=duration, start=start)])
    assert verdict.verdict == "named"
    assert [c.family for c in verdict.effects] == [family]


@pytest.mark.slow
@pytest.mark.parametrize("kind", [as_study("random"), "multisine"])
def test_nothing_is_found_where_nothing_is_hidden(kind):
    verdict = asked(DrivenJoint(), [joint_run({}, kind, seed=6)])
    assert verdict.verdict == "none"
    # 270 cosines and more: the reduced chi-square scatters by 0.09, the noise that it rests on by as much
    assert verdict.best.reduced == pytest.approx(1.0, abs=0.4)


@pytest.mark.slow
@pytest.mark.study
def test_an_unstable_component_in_a_closed_loop():
    rng = np.random.default_rng(7)
    time = np.arange(0, 12, 0.01)
    wanted = excitation("random", rng, 12, 2, 0.15)
    motion, torque = simulate(
        {"J": 0.1, "k": -4.0, "c": 0.05}, {}, None, time, feedback=lambda t, q, s: 12 * (wanted(t) - q) - 0.8 * s
    )
    columns = {"torque": torque, "angle": motion[:, 0] + 5e-4 * rng.standard_normal(len(time))}
    verdict = asked(
        Pendulum(gravity_stiffness=-3.0), [Recording("loop", time, columns, {"torque": "N.m", "angle": "rad"})]
    )
    assert verdict.verdict == "none"
    found = verdict.best.model.values(verdict.best.shared)
    assert found["gravity_stiffness"] == pytest.approx(-4.0, rel=0.02)
    assert parameters_of(verdict.best)["gravity_stiffness"][0] == pytest.approx(
        -4.0, rel=0.02
    )  # as verdict.json says it
    assert found["inertia"] == pytest.approx(0.1, rel=0.02)


@pytest.mark.slow
def test_an_imposed_angle_whose_torque_is_measured():
    rng = np.random.default_rng(8)
    time = np.arange(0, 12, 0.005)
    drive = excitation("random", rng, 12, 4, 0.05)
    angle, rate, acceleration = (drive(time, n) for n in range(3))
    torque = JOINT["J"] * acceleration + [
        resistance(JOINT, {}, q, s, 0.0, t, 12)[0] for q, s, t in zip(angle, rate, time, strict=True)
    ]
    columns = {
        "torque": torque + 0.02 * rng.standard_normal(len(time)),
        "angle": angle + 1e-5 * rng.standard_normal(len(time)),
    }
    verdict = asked(
        DrivenJoint(), [Recording("imposed", time, columns, {"torque": "N.m", "angle": "rad"})], imposed="angle"
    )
    assert verdict.verdict == "none"
    assert verdict.best.model.values(verdict.best.shared)["stiffness"] == pytest.approx(14.0, rel=0.02)


def imposed(hidden, size, seed):
    """A recording of the joint that is moved by so much (rms) [rad]."""
    rng, time = np.random.default_rng(seed), np.arange(0, 12, 0.01)
    drive = excitation("random", np.random.default_rng(3), 12, 3, size)
    torque = torque_for(JOINT, hidden, drive, time) + 0.02 * rng.standard_normal(len(time))
    return Recording(
        f"moved_by_{size:g}", time, {"torque": torque, "angle": drive(time)}, {"torque": "N.m", "angle": "rad"}
    )


@pytest.mark.slow
@pytest.mark.study
def test_a_larger_imposed_motion_settles_a_tie_by_as_much_as_was_said():
    run = imposed({"square": 2.4}, 0.05, 1)
    tied = asked(DrivenJoint(), [run], imposed="angle")
    assert tied.verdict == "tied" and "hardening_stiffness" in [c.family for c in tied.tied]
    proposed = next_experiment(tied, scaled_runs)
    assert "larger_excitation" in proposed["experiment"] and "imposed motion" in proposed["sentence"]
    settled = asked(DrivenJoint(), [run, imposed({"square": 2.4}, 2 * 0.05, 2)], imposed="angle")
    assert [c.effect.form for c in settled.effects] == ["square"]
    rival = max((c for c in settled.candidates if c.family == "backlash" and c.fitted), key=lambda c: c.delta_chi2)
    brought, said = settled.effects[0].delta_chi2 - rival.delta_chi2, proposed["expected_delta_chi2"]
    # A delta chi-square d scatters by 2 sqrt(d).
    assert brought > 10 and abs(brought - said) < 4 * 2 * np.sqrt(said)
    # Ended before its end, it would not seem to be a rival.
    assert rival.fit.chi2 - fit(rival.fit.model, rival.fit.runs, rival.fit.x).chi2 < 1.0


@pytest.fixture(scope="module")
def late():
    """Friction that follows late, as in a magnetorheological damper."""
    return asked(DrivenJoint(), [imposed({"late_friction": (0.8, 0.4, 0.03)}, 0.1, 1)], imposed="angle")


@pytest.mark.study
def test_friction_that_lags_is_found_with_its_lag(late):
    assert [(c.family, c.effect.form) for c in late.effects] == [("coulomb_friction", "lagging")]
    known = {n.rpartition(".")[2]: (value, error) for n, (value, error, _) in parameters_of(late.best).items()}
    for name, true in {"friction_torque": 0.8, "sliding_rate": 0.4, "lag": 0.03}.items():
        assert known[name][0] == pytest.approx(true, abs=3 * known[name][1]) and known[name][1] < 0.1 * true


@pytest.mark.study
def test_loops_show_what_an_imposed_motion_takes(late):
    (figure,) = (f for f, caption in pictures(late).before_and_after if "over deflection and over rate" in caption)
    recording = late.best.runs[0].recording
    time, *_ = left_over(late.best)
    motion = np.interp(time, recording.time, recording["angle"])
    for panel, expected in zip(figure.panels, (motion, np.gradient(motion, time)), strict=True):
        measured, base, found = panel.curves
        assert np.corrcoef(expected, measured.x)[0, 1] > 0.99  # but for the ends of a spline
        assert np.std(found.y - measured.y) < 0.03 < 0.1 < np.std(base.y - measured.y)  # the noise is 0.02 N.m


@pytest.mark.slow
@pytest.mark.study
@pytest.mark.parametrize(("column", "factor"), [("angle", 180 / np.pi), ("torque", 1e-3)])
def test_nothing_is_named_where_a_columns_unit_is_wrong(column, factor):
    recording = joint_run({"hardening": 40.0}, seed=5, duration=4.0)
    recording.columns[column] = factor * recording[column]  # degrees called radians, kN.m called N.m
    test = input_output_experiment(DrivenJoint(), list(recording.columns))
    found = investigate(test, [prepare_sampled_run(recording, test)])
    assert found.verdict.verdict == "unknown" and not found.verdict.effects
    expected = factor if column == "torque" else 1 / factor
    assert found.factor == pytest.approx(
        expected, rel=1.0
    )  # the joint itself is within a factor of two of where the fit starts


@pytest.mark.slow
@pytest.mark.study
def test_a_sensor_offset_is_not_fitted_as_asymmetry(tmp_path):
    """The offset differs between runs. If it were left out, a hardening spring would be asymmetric as well, or have
    backlash."""
    files = []
    for seed, off in ((4, -0.2), (3, 0.1)):  # of the rms
        run = joint_run({"hardening": 40.0}, "random", seed=seed, duration=6.0)
        added = off * np.std(run["torque"])
        run.columns["torque"] += added
        files.append(str(tmp_path / f"run_{seed}.csv"))
        write_recording(run, files[-1])
    assert (
        main(["gap", files[1], "--holdout", files[0], "--component", "driven_joint", "--out", str(tmp_path / "gap")])
        == 0
    )
    verdict = json.loads((tmp_path / "gap" / "verdict.json").read_text("utf-8"))
    assert [e["name"] for e in verdict["effects"]] == ["hardening_stiffness"]
    (said,) = (sentence for sentence in verdict["limitations"] if "a sensor offset" in sentence)
    value, error = map(float, re.search(r"recorded values plus (\S+) N.m \(standard error (\S+)\)", said).groups())
    assert abs(value + added) < 4 * error and error < 0.1 * added


def test_a_component_that_is_far_but_not_by_one_factor_has_its_units_right():
    joint = DrivenJoint()  # inertia 0.1, damping 0.2, stiffness 10
    assert common_factor(joint, {"inertia": 100.0, "damping": 200.0, "stiffness": 1e4}, Criteria()) == pytest.approx(
        1e3
    )
    assert common_factor(joint, {"inertia": 100.0, "damping": 1.0, "stiffness": 500.0}, Criteria()) == 1.0
    assert (
        common_factor(joint, {"inertia": 13.0, "damping": 20.0, "stiffness": 1300.0}, Criteria()) == 1.0
    )  # 130 is no unit's factor
    assert common_factor(joint, {"inertia": 9.5, "damping": 20.0, "stiffness": 950.0}, Criteria()) == 1.0  # nor is 95
    assert common_factor(joint, {"inertia": 0.7, "damping": 2.0, "stiffness": 90.0}, Criteria()) == 1.0


@pytest.mark.study
def test_the_reason_of_an_unknown_is_the_unit_that_may_be_wrong():
    """The friction is not named while kN may be labelled N; the joint has the parameters of its recording."""
    run = joint_run({"friction": 0.4}, "random", 1)
    run.columns["torque"] /= 1e3
    joint = DrivenJoint().with_values(inertia=JOINT["J"], damping=JOINT["c"], stiffness=JOINT["k"])
    verdict = asked(joint, [run])
    assert verdict.verdict == "unknown" and not verdict.effects
    assert "0.001 times their start values: is a column's unit wrong" in reason(verdict, [])


@pytest.mark.parametrize("unit_of_it", ["N.m/rad", "kg.m2", "W", "Pa", "J", "V"])
def test_what_scales_with_an_unknown_force_has_mass_in_its_unit(unit_of_it):
    class Scaled(DrivenJoint):
        other = parameter(unit_of_it, "A parameter", start=1.0)

    class Specific(DrivenJoint):
        other = parameter(f"{unit_of_it}/kg", "The same per mass", start=1.0)

    assert "other" in parameters_with_force_or_mass(Scaled())
    assert "other" not in parameters_with_force_or_mass(Specific())
