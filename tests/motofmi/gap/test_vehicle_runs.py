"""The gap workflow on recorded runs of a vehicle whose states are measured: an unstable bicycle under closed-loop control."""

import json
import re

import numpy as np
import pytest

import motofmi as mf
from fmus import InputError
from motofmi.cli.main import main
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.models.weak_form_model import WeakFormModel
from motofmi.gap.preprocessing.weak_form import prepare_weak_form
from motofmi.gap.selection.ties import equivalent
from motofmi.recordings.reading import read_recording
from motofmi.recordings.recording import Recording
from motofmi.workflows import components
from motofmi.workflows.gap.vehicle import vehicle_runs_experiment
from motofmi.workflows.gap.vehicle_equations import runs_effects, verdict_on_runs, weak_runs
from tests import SHARED_DATA, as_study
from tests.motofmi.json_schemas import check_against_schema
from tests.simulators.hidden_bicycle import bicycle, ride, write_matrices, write_ride

SHARE = 0.03  # by which the real bicycle differs from its matrices, which are taken as known to 10 %


def investigated(folder, seed, **hidden):
    rng = np.random.default_rng(seed)
    file = write_ride(folder / "run.csv", ride(rng, bicycle(rng, SHARE), **hidden))
    experiment = vehicle_runs_experiment(components.vehicle(write_matrices(folder / "bicycle.toml")))
    return verdict_on_runs(
        experiment, weak_runs([read_recording(file)], experiment), [], runs_effects(experiment.component)
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_where_nothing_is_hidden_nothing_is_named(tmp_path, seed):
    verdict = investigated(tmp_path, seed)
    assert verdict.verdict == "none"
    # 2000 numbers: their reduced chi-square has a deviation of 0.03, and the disturbance is estimated from the same
    # run.
    assert verdict.base.reduced == pytest.approx(1.0, abs=0.1)


def test_an_effect_that_explains_too_little_is_left_out_and_that_is_said_with_its_share(tmp_path):
    rng, said = np.random.default_rng(21), []
    file = write_ride(tmp_path / "run.csv", ride(rng, bicycle(rng, SHARE), duration=60.0, damping=0.15))
    experiment = vehicle_runs_experiment(components.vehicle(write_matrices(tmp_path / "bicycle.toml")))
    runs = weak_runs([read_recording(file)], experiment)
    damping = [e for e in runs_effects(experiment.component) if e.family == "steer_damping"]
    named = verdict_on_runs(experiment, runs, [], damping, criteria=Criteria(weak_form_linear_share=0.01))
    assert named.names == "steer_damping"
    share = named.effects[0].delta_chi2 / named.base.count
    verdict = verdict_on_runs(experiment, runs, [], damping, on_left_out=said.append)
    assert verdict.verdict in ("none", "unknown") and not verdict.candidates
    assert said == [f"steer_damping is left out: it explains {share:.3g} of the disturbance, less than 0.2."]


def test_the_limitations_name_what_is_left_out(tmp_path):
    rng = np.random.default_rng(21)
    file = write_ride(tmp_path / "run.csv", ride(rng, bicycle(rng, SHARE), duration=60.0, damping=0.15))
    found = mf.find_gap(file, vehicle=write_matrices(tmp_path / "bicycle.toml"))
    said = r"steer_damping is left out: it explains 0\.\d+ of the disturbance, less than 0\.2\."
    assert [s for s in found.limitations if re.fullmatch(said, s)]


@pytest.mark.study
def test_an_effect_that_only_feedback_causes_is_not_named(tmp_path):
    assert investigated(tmp_path, 21, pushed=5.0).verdict in ("none", "unknown")


@pytest.mark.slow
@pytest.mark.parametrize("hidden, name, parameter, truth", [
    ({"friction": 0.3}, "coulomb_friction", "friction_torque", 0.3), as_study({"damping": 1.5}, "steer_damping", "damping", 1.5),
])  # fmt: skip
def test_what_is_hidden_is_named_and_sized(tmp_path, hidden, name, parameter, truth):
    verdict = investigated(tmp_path, 10, **hidden)
    assert verdict.verdict == "named" and verdict.effects[0].family == name
    value, error, _ = parameters_of(verdict.best)[f"{name}.{parameter}"]
    # Ten per cent: the feedback's correlation with the disturbance moves a damping by five of them, beyond its standard
    # error.
    assert abs(value - truth) < max(0.1 * truth, 3 * error)
    # The coefficients of the torque are free: a gain of the motor is part of the base, and replaces no friction.
    assert "motor_gain" not in equivalent(verdict.best, verdict.effects[0], verdict.candidates)


@pytest.mark.study
def test_the_command_writes_the_vehicle_and_compares_with_a_validation_run(tmp_path):
    rng = np.random.default_rng(3)
    real = bicycle(rng, SHARE)
    files = [write_ride(tmp_path / f"{name}.csv", ride(rng, real, friction=0.3)) for name in ("run", "held")]
    vehicle = write_matrices(tmp_path / "bicycle.toml")
    assert main(["gap", files[0], "--holdout", files[1], "--vehicle", vehicle, "--out", str(tmp_path / "gap")]) == 0
    verdict = json.loads((tmp_path / "gap" / "verdict.json").read_text("utf-8"))
    check_against_schema("verdict", verdict)
    assert verdict["verdict"] == "named" and verdict["effects"][0]["name"] == "coulomb_friction"
    assert verdict["noise_source"] == "flexible_model" and any(
        "flexible" in sentence for sentence in verdict["limitations"]
    )
    before, after = verdict["gap"]["holdout_before"], verdict["gap"]["holdout_after"]
    assert after - 1 < 0.1 * (before - 1), "nine tenths of the gap close on the run that was not used"
    assert (tmp_path / "gap" / verdict["report"]).exists() and (tmp_path / "gap" / verdict["fmu"]).exists()
    # What was written is a vehicle again.
    assert "coulomb_friction.friction_torque" in components.vehicle(str(tmp_path / "gap" / verdict["model"])).values


def recording(**changed):
    rng = np.random.default_rng(0)
    time, speed, roll, roll_rate, steer, steer_rate, torque = ride(rng, bicycle(rng, SHARE)).T
    columns = {
        "speed": speed,
        "roll_angle": roll,
        "roll_rate": roll_rate,
        "steer_angle": steer,
        "steer_rate": steer_rate,
        "steer_torque": torque,
    }
    return Recording("run", time, columns | changed, dict.fromkeys(columns, "1"))


def prepared(run):
    return prepare_weak_form(run, "speed", ("roll_rate", "steer_rate"), tuple(run.columns), ())


@pytest.mark.slow
def test_the_weak_form_of_a_rate_is_that_of_its_derivative():
    time = np.arange(0, 40, 0.01)
    run = recording()
    run = prepared(
        Recording(
            "sine",
            time,
            {n: np.full(len(time), 4.0) if n == "speed" else np.sin(2 * np.pi * 1.3 * time) for n in run.columns},
            run.units,
        )
    )
    exact = run.tested(2 * np.pi * 1.3 * np.cos(2 * np.pi * 1.3 * time)[run.places])
    # The sums stand for integrals: their error is that of the midpoint rule at the ends, (w h)^2 / 24 of the largest.
    assert run.measured[0] == pytest.approx(exact, abs=2e-3 * np.abs(exact).max())


@pytest.mark.parametrize("effect", ["no effect", "coulomb_friction.soft", "coulomb_friction.stribeck", "channel_delay.motor", "motor_gain.ratio"])
def test_the_derivatives_of_the_weak_form_are_those_by_differences(tmp_path, effect):
    experiment = vehicle_runs_experiment(components.vehicle(write_matrices(tmp_path / "bicycle.toml")))
    (run,) = weak_runs([recording()], experiment)
    model = WeakFormModel(experiment)
    effects = [e for e in runs_effects(experiment.component) if f"{e.family}.{e.form}" == effect]
    assert len(effects) == (effect != "no effect")
    model = model.with_added_effects(*effects)
    q = model.start()
    q[len(experiment.free) :] += 0.1 * np.maximum(np.abs(q[len(experiment.free) :]), 0.01)  # no magnitude is zero
    value, slopes = model.reduced(run, q)
    assert value == pytest.approx(model.predicted(run, q), rel=1e-12)
    for i, name in enumerate(model.names):
        step = np.zeros(len(q))
        # Central differences: their curvature and rounding are both near 1e-8. A delay moves samples over the kinks of
        # the linear interpolation: one in 10^4 per 10^-6 s.
        step[i] = 1e-6 if name.endswith("delay") else 1e-5 * max(abs(q[i]), 1e-2)
        difference = (model.predicted(run, q + step) - model.predicted(run, q - step)) / (2 * step[i])
        close = 1e-3 if name.endswith("delay") else 1e-6
        assert slopes[:, i] == pytest.approx(difference, abs=close * np.abs(difference).max(initial=1e-9)), name


@pytest.mark.slow
def test_starts_stops_and_wild_samples_are_cut_and_that_is_said():
    run = recording()
    run.columns["speed"][:1500] = np.linspace(0, 3.9, 1500)
    run.columns["steer_rate"][6000] = -22.0
    run_in_use = prepared(run)
    assert not ({6000, *range(1200)} & set(run_in_use.places.ravel().tolist()))
    assert "samples below 80% of the usual speed and 1 outliers" in run_in_use.notes[-1]


@pytest.mark.slow
def test_a_run_that_is_too_short_is_refused():
    short = recording()
    seconds = short.time[1499] - short.time[0]
    with pytest.raises(InputError, match=rf"short: {seconds:.3g} s long, .* expected at least 2\. .*its eigenvalues"):
        prepared(Recording("short", short.time[:1500], {n: x[:1500] for n, x in short.columns.items()}, short.units))


MEASURED = SHARED_DATA / "measured" / "steer_by_wire_bicycle"
AUTHORS = """
A0 = [[0, 0, 1, 0], [0, 0, 0, 1], [13.5934863142, -0.438988101746, 0, 0], [2.4476559527, 23.0914910644, 0, 0]]
A1 = [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, -0.187133919764, -0.539355760804], [0, 0, 3.82992579518, -3.18311895912]]
A2 = [[0, 0, 0, 0], [0, 0, 0, 0], [0, -1.29589144233, 0, 0], [0, -0.86139430207, 0, 0]]
B = [[0, 0], [0, 0], [0.0953640872087, -0.454498760802], [-0.454498760802, 9.30187605789]]
"""


@pytest.mark.slow
@pytest.mark.study
@pytest.mark.skipif(
    not MEASURED.exists(), reason=f"the measured runs of the steer-by-wire bicycle are not at {MEASURED}"
)
def test_the_steer_by_wire_bicycle_lacks_something_and_friction_leads_without_being_all_of_it(tmp_path):
    (tmp_path / "authors.toml").write_text(AUTHORS)
    experiment = vehicle_runs_experiment(components.vehicle(str(tmp_path / "authors.toml")), ["all"])
    runs = weak_runs([read_recording(MEASURED / f"bode_4mps_{f}Hz.csv") for f in ("1.0", "1.8")], experiment)
    verdict = verdict_on_runs(experiment, runs, [], runs_effects(experiment.component))
    assert verdict.verdict != "none" and verdict.candidates[0].family == "coulomb_friction"
    assert verdict.best.reduced < verdict.base.reduced
