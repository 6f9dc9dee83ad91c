"""`find_gap` from Python: recordings as objects, a result that writes nothing unless asked to, and errors before any fit."""

import json
from dataclasses import replace

import numpy as np
import pytest

import motofmi as mf
from fmus.mechanisms import DrivenJoint
from fmus.support.plain_json import to_json
from motofmi.cli.main import main
from motofmi.gap.criteria import Criteria
from motofmi.recordings.reading import write_recording
from motofmi.workflows.gap.given import Given
from motofmi.workflows.gap.input_output import InputOutput
from tests.motofmi.json_schemas import check_against_schema
from tests.simulators.hidden_joint import joint_run

FRICTION = 0.3  # N.m


@pytest.fixture(scope="module")
def runs():
    return [
        joint_run({"friction": FRICTION}, "multisine", seed=9 + i, duration=5.0, name=name)
        for i, name in enumerate(("fit", "held"))
    ]


@pytest.fixture(scope="module")
def found(runs, tmp_path_factory):
    """In a folder of its own, into which nothing is written."""
    folder = tmp_path_factory.mktemp("empty")
    with pytest.MonkeyPatch.context() as patched:
        patched.chdir(folder)
        result = mf.find_gap(runs[0], validation=runs[1], component=DrivenJoint())
    assert not list(folder.iterdir())
    return result


@pytest.mark.slow
def test_the_effect_is_found_in_recordings_that_are_objects(found):
    assert (found.verdict, [e["name"] for e in found.effects], found.tied) == ("named", ["coulomb_friction"], [])
    torque = found.effects[0]["parameters"]["friction_torque"]
    assert torque["value"] == pytest.approx(FRICTION, abs=3 * torque["standard_error"])
    assert found.gap["holdout_after"] < 1.5 < found.gap["holdout_before"]
    assert found.where and found.next_experiment is None and found.candidates[0]["name"] == "coulomb_friction"


@pytest.mark.slow
def test_the_model_is_a_component_with_the_effect(found):
    assert (
        found.model.values["coulomb_friction.friction_torque"]
        == found.effects[0]["parameters"]["friction_torque"]["value"]
    )
    rates, _ = found.model.derivatives(np.array([0.0, 2.0]), np.zeros(1))
    values = found.model.values
    # J s' = T - c s - F at a rate far above the sliding rate; k q is zero
    assert rates[1] == pytest.approx(
        -(2.0 * values["damping"] + values["coulomb_friction.friction_torque"]) / values["inertia"], rel=1e-3
    )


@pytest.mark.slow
def test_the_result_shows_itself(found):
    assert "coulomb_friction" in repr(found) and "N.m" in repr(found) and len(repr(found)) < 400
    assert "<table>" in found._repr_html_() and "data:image/png" in found._repr_html_()
    axes = found.plot()
    assert "[1]" in axes.get_xlabel() and len(axes.patches) == 4
    assert found.to_dataframe()["name"].iloc[0] == "coulomb_friction"
    check_against_schema("verdict", json.loads(to_json(found.to_dict())))
    assert "modes" in found.to_dict()


@pytest.mark.study
def test_saved_it_is_what_the_command_writes(found, runs, tmp_path):
    paths = found.save(tmp_path / "api")
    assert {p.name for p in paths} >= {"verdict.json", "report.html", "augmented_component.toml"} and all(
        p.exists() for p in paths
    )
    files = [str(tmp_path / f"{run.name}.csv") for run in runs]
    for run, file in zip(runs, files, strict=True):
        write_recording(run, file)
    assert (
        main(["gap", files[0], "--holdout", files[1], "--component", "driven_joint", "--out", str(tmp_path / "cli")])
        == 0
    )
    api, cli = (json.loads((tmp_path / name / "verdict.json").read_text("utf-8")) for name in ("api", "cli"))
    assert api.keys() == cli.keys() and api["effects"][0]["name"] == cli["effects"][0]["name"]
    # A CSV file holds six digits of each sample, and the noise is estimated: some 400 cosines scatter by 7 %.
    assert api["gap"]["after"] == pytest.approx(cli["gap"]["after"], rel=0.03)
    assert mf.component(tmp_path / "api" / api["model"]).values == pytest.approx(found.model.values)


@pytest.mark.study
def test_criteria_decide(runs):
    strict = mf.find_gap(runs[0], component="driven_joint", criteria=Criteria(first_effect_delta_bic=1e9))
    assert strict.verdict != "named" and strict.to_dict()["criteria"]["first_effect_delta_bic"] == 1e9


def test_faults_of_the_sampling_of_a_validation_run_are_notes_with_its_name(runs):
    fit, held = runs
    jittered = replace(held, warnings=("sampling jitter of 3 % of the interval",))
    prepared = InputOutput(Given([fit], [jittered], component=DrivenJoint()))
    assert "held: sampling jitter of 3 % of the interval" in prepared.notes


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"recordings": []}, "no recordings"),
        ({"component": "driven_joint", "vehicle": "sharp_1971"}, "both component and vehicle"),
        ({"component": "driven_joint", "rig": "nowhere.json"}, "cannot read nowhere.json"),
        ({"component": "driven_join"}, "did you mean"),
        ({"vehicle": "sharp_1971"}, "speed"),
        ({"component": "driven_joint", "impose": "torque"}, "impose"),
    ],
)
def test_what_cannot_be_used_is_said_before_anything_is_fitted(arguments, message, runs):
    with pytest.raises(mf.InputError, match=message):
        mf.find_gap(**{"recordings": runs[0], **arguments})


@pytest.mark.slow
def test_a_folder_that_cannot_be_written_is_noticed_first(runs, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(mf.InputError, match=r"cannot write .*file.*verdict.json: .*file is not a folder"):
        mf.find_gap(runs[0], component="driven_joint", out=tmp_path / "file")


@pytest.mark.slow
def test_eigenvalues_without_a_vehicle_name_the_missing_option(tmp_path, capsys):
    rows = [f"{speed},weave,-1.0,10.0,0.1,0.1" for speed in (10, 20, 30, 40)]
    file = tmp_path / "eigenvalues.csv"
    file.write_text("\n".join(["speed [m/s],mode,real [1/s],imag [1/s],real_se [1/s],imag_se [1/s]", *rows]))
    assert main(["gap", str(file), "--out", str(tmp_path / "gap")]) == 2
    assert "need the vehicle" in (said := capsys.readouterr().err) and "--vehicle sharp_1971" in said
