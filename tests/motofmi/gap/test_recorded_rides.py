"""The gap workflow on runs of a motorcycle of which only some states are recorded: what is named, and its size."""

import json
from dataclasses import fields

import numpy as np
import pytest

from fmus import InputError
from fmus.composition.value_files import value_file
from motofmi.cli.main import main
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import parameters_of
from motofmi.gap.preprocessing.predicted_run import PredictedRun
from motofmi.recordings.reading import read_recording
from motofmi.workflows.gap.vehicle import vehicle_runs_experiment
from motofmi.workflows.gap.vehicle_predictions import (
    predictable_effects,
    predicted_runs,
    verdict_on_predictions,
)
from tests.motofmi.gap.test_one_step_prediction import STEERED, motorcycles
from tests.simulators.hidden_ride import ride, write_ride

# The families that come nearest to what is hidden here; the whole library is compared in benchmarks.gap_vehicle_runs.
RIVALS = {"channel_delay", "coulomb_friction", "steer_damping", "frame_compliance"}


def investigated(folder, seed, hidden, speed=20.0, duration=60.0, **logged):
    base, real, rng = motorcycles(seed)
    pushed = logged.pop("pushed", 1.0)
    file = write_ride(folder / "run.csv", ride(rng, real, speed, hidden, duration, pushed, gain=STEERED), rng, **logged)
    experiment = vehicle_runs_experiment(base)
    runs = predicted_runs([read_recording(file)], experiment)
    library = [e for e in predictable_effects(base, experiment, runs) if e.family in RIVALS]
    return verdict_on_predictions(experiment, runs, [], library)


class WithoutPrediction(PredictedRun):
    """A run in which no vehicle can be predicted."""

    @property
    def data(self):
        raise InputError(f"known: the prediction of {self.name} diverges")


@pytest.mark.slow
def test_effects_and_validation_runs_that_are_left_out_are_said_with_the_reason(tmp_path):
    base, real, rng = motorcycles(1)
    file = write_ride(tmp_path / "run.csv", ride(rng, real, 20.0, {"motor": 2}, 26.0, gain=STEERED), rng)
    experiment, said = vehicle_runs_experiment(base), []
    (run,) = predicted_runs([read_recording(file)], experiment)
    library = [
        e for e in predictable_effects(base, experiment, [run]) if (e.family, e.form) == ("channel_delay", "motor")
    ]
    verdict = verdict_on_predictions(
        experiment, [run], [WithoutPrediction(**{f.name: getattr(run, f.name) for f in fields(run)})], library,
        criteria=Criteria(prediction_linear_share=0.9), on_left_out=said.append,
    )  # fmt: skip
    assert verdict.verdict != "named" and verdict.candidates[0].family == "channel_delay"
    gain = 100 * verdict.candidates[0].delta_chi2 / verdict.base.count
    assert set(said) == {
        "run: not used for validation, because of an error: known: the prediction of run diverges.",
        "Left out are effects that gain less than 90 % of the noise's power for each of their parameters: "
        f"channel_delay gains {gain:.3g} % (1 parameter).",
    }


@pytest.mark.study
def test_where_nothing_is_hidden_nothing_is_named(tmp_path):
    verdict = investigated(tmp_path, 1, {}, duration=40.0)
    assert verdict.verdict == "none"
    # 4100 numbers: a deviation of 0.02, the floor from the same run.
    assert verdict.base.reduced == pytest.approx(1.0, abs=0.08)


@pytest.mark.slow
@pytest.mark.study
def test_a_motor_that_is_late_is_named_and_sized(tmp_path):
    verdict = investigated(tmp_path, 5, {"motor": 4}, duration=40.0)
    assert (
        verdict.verdict == "named"
        and [c.family for c in verdict.effects] == ["channel_delay"]
        and verdict.effects[0].effect.form == "motor"
    )
    value, error, _ = parameters_of(verdict.best)["channel_delay.delay"]
    # 40 ms; the late torque is held over 10 ms in the simulation, which is half of that later.
    assert 0.04 - 3 * error < value < 0.045 + 3 * error


@pytest.mark.slow
@pytest.mark.study
def test_a_sensor_that_is_late_is_named_and_sized(tmp_path):
    verdict = investigated(tmp_path, 1, {}, duration=30.0, late={"yaw_rate": 4})
    assert verdict.verdict == "named" and [(c.family, c.effect.form) for c in verdict.effects] == [
        ("channel_delay", "yaw_rate")
    ]
    value, error, _ = parameters_of(verdict.best)["channel_delay.delay"]
    assert abs(value - 0.04) < 3 * error
    assert verdict.best.reduced < 1.12 < verdict.base.reduced


@pytest.mark.slow
@pytest.mark.study
def test_dry_friction_in_the_steering_head_is_named_and_sized(tmp_path):
    verdict = investigated(tmp_path, 2, {"friction": 1.0}, duration=40.0, pushed=0.0)
    assert verdict.verdict == "named" and [c.family for c in verdict.effects] == ["coulomb_friction"]
    value, error, _ = parameters_of(verdict.best)["coulomb_friction.friction_torque"]
    assert abs(value - 1.0) < 3 * error


@pytest.mark.slow
@pytest.mark.study
def test_without_its_torque_nothing_is_looked_for_that_hands_do_too(tmp_path):
    base, real, rng = motorcycles(1)
    file = write_ride(tmp_path / "run.csv", ride(rng, real, 20.0, {}, 40.0, gain=STEERED), rng, torque=False)
    experiment = vehicle_runs_experiment(base)
    runs = predicted_runs([read_recording(file)], experiment)
    families = {e.family for e in predictable_effects(base, experiment, runs)}
    assert "frame_compliance" in families and not families & {
        "coulomb_friction",
        "steer_damping",
        "steer_stiffness",
        "added_inertia",
        "motor_gain",
    }
    assert verdict_on_predictions(experiment, runs, [], predictable_effects(base, experiment, runs)).verdict in (
        "none",
        "unknown",
    )


@pytest.mark.slow
@pytest.mark.study
def test_a_front_frame_that_twists_is_named_and_sized_and_the_vehicle_written(tmp_path):
    base, real, rng = motorcycles(3)
    hidden = {"compliance": 3e-5, "axis": 0.4}
    files = [
        write_ride(tmp_path / f"{n}.csv", ride(rng, real, v, hidden, 40.0, gain=STEERED), rng)
        for n, v in (("run", 20.0), ("held", 21.0))
    ]
    (tmp_path / "known.toml").write_text(
        value_file("Motorcycle", {n: (x, None, base.table[n].unit) for n, x in base.values.items()}, "known", "test"),
        "utf-8",
    )
    out = tmp_path / "gap"
    assert (
        main(["gap", files[0], "--holdout", files[1], "--vehicle", str(tmp_path / "known.toml"), "--out", str(out)])
        == 0
    )
    result = json.loads((out / "verdict.json").read_text("utf-8"))
    assert result["verdict"] == "named" and [e["name"] for e in result["effects"]] == ["frame_compliance"]
    found = result["effects"][0]["parameters"]["compliance"]
    assert abs(found["value"] - 3e-5) < 3 * found["standard_error"]
    gap = result["gap"]
    assert gap["holdout_after"] - 1 < 0.1 * (gap["holdout_before"] - 1), (
        "nine tenths of the gap close on the run that was not used"
    )
    assert any("predicted one sample ahead" in sentence for sentence in result["limitations"])
    assert (out / result["report"]).exists() and (out / result["fmu"]).exists()


@pytest.mark.parametrize("header, message", [
    ("time [s],roll_rate [rad/s],steer_torque [N.m]", "expected a column speed"), ("time [s],speed [m/s],steer_torque [N.m]", "no column is an output"),
])  # fmt: skip
def test_a_run_without_speed_or_any_output_is_refused(tmp_path, header, message):
    rng = np.random.default_rng(0)
    count = header.count(",")
    rows = "\n".join(",".join(map(str, (k / 100, *rng.uniform(4, 5, count)))) for k in range(3000))
    (tmp_path / "run.csv").write_text(f"{header}\n{rows}\n")
    experiment = vehicle_runs_experiment(motorcycles(0)[0])
    with pytest.raises(InputError, match=message):
        predicted_runs([read_recording(tmp_path / "run.csv")], experiment)


def test_a_run_that_holds_nothing_but_noise_is_refused(tmp_path):
    rng = np.random.default_rng(0)
    rows = "\n".join(f"{k / 100},20,{x:.6f}" for k, x in enumerate(1e-3 * rng.standard_normal(4000)))
    (tmp_path / "run.csv").write_text(f"time [s],speed [m/s],roll_rate [rad/s]\n{rows}\n")
    with pytest.raises(InputError, match="no excitation"):
        predicted_runs([read_recording(tmp_path / "run.csv")], vehicle_runs_experiment(motorcycles(0)[0]))
