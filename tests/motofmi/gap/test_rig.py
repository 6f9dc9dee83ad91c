"""Effects hidden in recordings by a simulator written apart are found again; where nothing is hidden, nothing is."""

import json

import numpy as np
import pytest

from fmus.support.errors import InputError
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run, require_unclipped
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.verdict import as_result
from motofmi.recordings.reading import read_recording
from motofmi.workflows.gap.rig import rig_effects, rig_experiment, with_bare_bar
from tests import SHARED_DATA

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
from tests.motofmi.json_schemas import check_against_schema
from tests.simulators.as_recordings import as_recording
from tests.simulators.hidden_rig import RUNS, case, record
from tests.simulators.rig_runs import RIG, prepared

SOLVED = SHARED_DATA / "gap_open"


@pytest.mark.study
@pytest.mark.parametrize(("hidden", "family", "parameter", "value"), [
    ({"Tc": 0.5}, "coulomb_friction", "friction_torque", 0.5),
    ({"ra": 0.05}, "asymmetry", "ratio", 0.05),
])  # fmt: skip
def test_a_hidden_effect_is_named_with_its_size(hidden, family, parameter, value):
    made, _ = case(hidden, seed=11)
    runs = prepared(made)
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), runs[:2], rig_effects(), runs[2:])
    result = as_result(verdict, "N.m")
    assert result["verdict"] == "named"
    assert [e["name"] for e in result["effects"]] == [family]
    found = result["effects"][0]["parameters"][parameter]
    # 5 % or two standard errors
    assert abs(found["value"] - value) < max(0.05 * value, 2 * found["standard_error"])
    # 900 reduced numbers scatter by 0.05 about 1; twice that, and the rider's own noise below 2 Hz as much again
    assert result["gap"]["holdout_after"] == pytest.approx(1.0, abs=0.2)
    assert result["gap"]["holdout_before"] > 2
    assert result["where"][0]["p_value"] < 1e-6


@pytest.mark.slow
def test_nothing_is_found_where_nothing_is_hidden():
    made, rider = case({}, seed=12)
    runs = prepared(made)
    verdict = select_model(HarmonicModel(rig_experiment(RIG)), runs[:2], rig_effects(), runs[2:])
    result = as_result(verdict, "N.m")
    check_against_schema("verdict", result)
    assert (result["verdict"], result["effects"], result["tied"]) == ("none", [], [])
    assert result["base"]["device.arm_stiffness"]["value"] == pytest.approx(
        rider["ka"], rel=0.1
    )  # the rider changes by 3 %, three deviations


@pytest.mark.slow
def test_the_model_meets_the_other_simulator():
    """Noise-free, the two simulators agree: fourth-order collocation at 128 Hz against RK4 at 2048 Hz."""
    made, rider = case({"k3": 2e4}, seed=13, noise=1e-9, change=0.0, runs=("sweep_up",))
    run = prepared(made)[0]
    hardening = next(e for e in rig_effects() if e.family == "hardening_stiffness" and e.form == "cubic")
    model = HarmonicModel(rig_experiment(RIG), [hardening])
    names = {"Is": "bar.steer_inertia", "It": "device.torso_inertia", "ka": "device.arm_stiffness", "kt": "device.waist_stiffness",
             "ca": "device.arm_damping", "ct": "device.waist_damping"}  # fmt: skip
    start = model.start({names[n]: v for n, v in rider.items()} | {"device.hardening_stiffness.cubic_stiffness": 2e4})
    simulated = model.outputs(run, start, slopes=False)[0][:, 0]
    inside = np.concatenate([np.arange(first, last) for first, last, _ in run.reduction.bases])
    error = simulated[inside] - run.effort.measured[inside]
    # The converters' steps (0.098 N.m: 0.03 rms; 0.17 mrad in the angle) are what is left of a torque of tens of N.m
    assert np.sqrt(np.mean(error**2)) < 0.01 * np.sqrt(np.mean(run.effort.measured[inside] ** 2))


@pytest.mark.slow
def test_a_bare_bar_gives_its_own_inertia_and_damping():
    bare = {"Is": 0.125, "It": 1e6, "ka": 1e-6, "kt": 1.0, "ca": 1e-6, "ct": 1.0}
    arrays = record(RUNS["sweep_up"], {"cs": 0.8}, bare, np.random.default_rng(0))
    experiment = with_bare_bar(rig_experiment(RIG), prepared({"bare": arrays}))
    assert experiment.free[0].known == pytest.approx(0.125, abs=4 * experiment.free[0].standard_error)
    value, error = experiment.measured_effects["device.steer_damping.damping"]
    assert value == pytest.approx(0.8, abs=4 * error)


@pytest.mark.slow
def test_recordings_that_cannot_be_used_are_refused():
    made, _ = case({}, seed=15, runs=("sweep_up",))
    time, command, angle, torque, _ = made["sweep_up"]
    short = as_recording("short", (time[:1000], command[:1000], angle[:1000], torque[:1000]))
    with pytest.raises(InputError, match="too short"):
        prepare_steer_test_run(short, "steer_angle", "steer_torque", "steer_angle_command")
    rng = np.random.default_rng(1)
    still = as_recording("still", (time, command, 1e-4 * rng.standard_normal(len(time)), torque))
    with pytest.raises(InputError, match="no excitation"):
        prepare_steer_test_run(still, "steer_angle", "steer_torque", "steer_angle_command")
    require_unclipped([short])


@pytest.mark.slow
@pytest.mark.study
@pytest.mark.skipif(not SOLVED.exists(), reason="the solved cases are not beside this checkout")
def test_a_solved_case():
    truth = json.loads((SOLVED / "truth.json").read_text())
    recordings = [read_recording(SOLVED / "case_06" / f"{n}.csv") for n in ("sweep_up_2deg", "stepped_4deg")]
    runs = [prepare_steer_test_run(r, "steer_angle", "steer_torque", "steer_angle_command") for r in recordings]
    verdict = select_model(HarmonicModel(rig_experiment(recordings[0].rig)), runs, rig_effects())
    assert [c.family for c in verdict.effects] == truth["case_06"]["effects"]
