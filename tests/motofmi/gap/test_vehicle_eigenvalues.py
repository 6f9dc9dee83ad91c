"""The gap workflow on measured eigenvalues of vehicles that are made apart from the package."""

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.gap_vehicle import case
from fmus import InputError, linearise
from motofmi.cli.main import main
from motofmi.gap.estimation.candidate import Candidate
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.models.eigenvalue_model import EigenvalueModel
from motofmi.gap.preprocessing.eigenvalues import EXAMPLE, read_eigenvalues
from motofmi.gap.selection.result import Verdict
from motofmi.workflows.gap.vehicle import vehicle_effects, vehicle_experiment, with_mode_names
from motofmi.workflows.gap.vehicle_eigenvalues import next_measurement
from tests.motofmi.json_schemas import check_against_schema
from tests.simulators.hidden_vehicle import SHARP, known_to, matrix, spectrum, write
from vehicle_fmu import modes, motorcycles, over_speed, ridden

SPEEDS = np.arange(8.0, 57.0, 4.0)


def measured(folder, hidden, seed=0, name="eigenvalues.csv", error=0.01, p=SHARP):
    rng = np.random.default_rng(seed)
    write(folder / name, spectrum(known_to(rng, p), SPEEDS, hidden), SPEEDS, rng, error)
    return str(folder / name)


def gap(folder, *arguments):
    assert main(["gap", *arguments, "--vehicle", "sharp_1971", "--out", str(folder / "gap")]) == 0
    found = json.loads((folder / "gap" / "verdict.json").read_text("utf-8"))
    check_against_schema("verdict", found)
    return found


@pytest.mark.slow
def test_the_simulated_motorcycle_is_that_of_the_package_where_nothing_is_hidden():
    own = np.sort_complex(np.linalg.eigvals(matrix(SHARP, 30.0, {})))
    assert own == pytest.approx(
        np.sort_complex(np.linalg.eigvals(linearise(motorcycles.load("sharp_1971"), speed=30.0).A)), rel=1e-8
    )


@pytest.mark.study
def test_frame_compliance_is_named_estimated_and_confirmed_at_validation_speeds(tmp_path):
    hidden = {"compliance": 3e-5, "axis": 0.4}
    p = known_to(np.random.default_rng(7), SHARP)
    rng = np.random.default_rng(8)
    for name, speeds in (("eigenvalues.csv", SPEEDS), ("held.csv", SPEEDS[:-1] + 2)):
        write(tmp_path / name, spectrum(p, speeds, hidden), speeds, rng, 0.01)
    verdict = gap(tmp_path, str(tmp_path / "eigenvalues.csv"), "--holdout", str(tmp_path / "held.csv"))
    assert verdict["verdict"] == "named"
    assert [e["name"] for e in verdict["effects"]] == ["frame_compliance"]
    compliance = verdict["effects"][0]["parameters"]["compliance"]
    # Three standard errors: one case in 400 lies beyond.
    assert abs(compliance["value"] - 3e-5) < 3 * compliance["standard_error"]
    # 70 numbers: their reduced chi-square has a deviation of 0.17; those of the validation speeds include the errors of
    # the fit.
    assert (
        verdict["gap"]["after"] < 1.6 and verdict["gap"]["holdout_after"] < 2.0 < 5.0 < verdict["gap"]["holdout_before"]
    )
    assert verdict["noise_source"] == "given" and {"wobble real", "wobble imag"} & {w["axis"] for w in verdict["where"]}
    assert (tmp_path / "gap" / verdict["fmu"]).exists() and (tmp_path / "gap" / verdict["report"]).exists()
    assert (
        main(
            [
                "modes",
                "--vehicle",
                str(tmp_path / "gap" / verdict["model"]),
                "--speed",
                "40",
                "--json",
                str(tmp_path / "modes.json"),
            ]
        )
        == 0
    )
    wobble = complex(*json.loads((tmp_path / "modes.json").read_text())["modes"]["wobble"]["eigenvalue"][0])
    truth = spectrum(p, np.array([30.0, 40.0]), hidden)["wobble"][1]
    assert abs(wobble - truth) < 0.02 * abs(truth)  # twice the error of one measurement, of which there are 13


@pytest.mark.study
def test_a_rejection_at_validation_speeds_is_reported(tmp_path):
    """The validation eigenvalues are those of another motorcycle, whose frame is rigid."""
    p, rng = known_to(np.random.default_rng(7), SHARP), np.random.default_rng(8)
    for name, hidden in (("eigenvalues.csv", {"compliance": 3e-5, "axis": 0.4}), ("held.csv", {})):
        write(tmp_path / name, spectrum(p, SPEEDS, hidden), SPEEDS, rng, 0.01)
    verdict = gap(tmp_path, str(tmp_path / "eigenvalues.csv"), "--holdout", str(tmp_path / "held.csv"))
    assert verdict["verdict"] == "unknown"
    assert any("rejects" in sentence and "frame_compliance" in sentence for sentence in verdict["limitations"])


@pytest.mark.slow
@pytest.mark.parametrize("name, seed", [
    ("added_inertia", 11),
    *(pytest.param(*each, marks=pytest.mark.study)
      for each in [("tyre_relaxation", 4), ("aerodynamics", 7), ("rider_lean", 2), ("roll_inertia", 5), ("steer_damping", 8), ("steer_stiffness", 16)]),
])  # fmt: skip
def test_what_is_hidden_is_named_or_in_the_tie(tmp_path, name, seed):
    found = case(name, 5000 + seed, tmp_path)
    assert name in found["names"], found


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.study) for seed in range(1, 8))])
def test_where_nothing_is_hidden_nothing_is_named(tmp_path, seed):
    assert case("none", 100 + seed, tmp_path)["verdict"] == "none"


@pytest.mark.study
@pytest.mark.parametrize(
    "name", ["controller", "another tyre", "another yaw inertia"]
)
def test_what_no_effect_of_the_library_does_is_not_named(tmp_path, name):
    assert case(name, 6000, tmp_path)["verdict"] in ("unknown", "none")


@pytest.mark.slow
def test_slopes_of_eigenvalues_are_those_of_differences(tmp_path):
    experiment = vehicle_experiment(motorcycles.load("sharp_1971"))
    run = with_mode_names(read_eigenvalues(measured(tmp_path, {})), experiment)
    model = EigenvalueModel(experiment)
    q = model.start()
    slopes = model.reduced(run, q)[1]
    for i in (0, len(q) // 2, len(q) - 1):
        step = np.zeros(len(q))
        step[i] = 1e-4
        differences = (model.reduced(run, q + step)[0] - model.reduced(run, q - step)[0]) / 2e-4
        # The difference's own error is the third derivative's share, 1e-8 times numbers that are up to 1e3 larger.
        assert slopes[:, i] == pytest.approx(differences, rel=1e-4, abs=1e-4 * np.abs(differences).max())


@pytest.mark.study
def test_eigenvalues_without_names_are_matched_by_distance(tmp_path):
    path = measured(tmp_path, {"damper": 6.0})
    text = Path(path).read_text()
    for mode in ("weave", "wobble", "capsize"):
        text = text.replace(mode, "")
    Path(path).write_text(text)
    verdict = gap(tmp_path, path)
    assert [e["name"] for e in verdict["effects"]] == ["steer_damping"]
    assert any("without a mode's name" in sentence for sentence in verdict["limitations"])


@pytest.mark.slow
def test_a_parameter_that_is_free_may_be_anything(tmp_path):
    path = measured(tmp_path, {"damper": 6.0})
    assert gap(tmp_path, path, "--free", "steering_damping")["verdict"] == "none"


@pytest.mark.slow
@pytest.mark.parametrize("change, expected", [
    (lambda t: t.replace("real_se", "error"), "no column real_se"),
    (lambda t: t.replace("real [1/s]", "real [rad]"), "cannot be converted"),
    (lambda t: "\n".join(t.splitlines()[:3]), "expected at least 4"),
    (lambda t: t.replace("weave,", "weave,x", 1), "not a number"),
    (lambda t: "\n".join([EXAMPLE, *(["10,weave,-1,20,0,0.1"] * 5)]), "standard error above zero"),
])  # fmt: skip
def test_a_file_that_cannot_be_used_is_refused_with_its_fault(tmp_path, change, expected):
    path = measured(tmp_path, {})
    text = change(Path(path).read_text())
    Path(path).write_text(text)
    with pytest.raises(InputError, match=expected):
        read_eigenvalues(path)


LAST = "speed,real,imag,real_se,imag_se,mode"  # a short row has no mode


def test_a_row_without_its_last_cell_has_no_mode(tmp_path):
    path = tmp_path / "eigenvalues.csv"
    path.write_text("\n".join([LAST, *["10,-1,20,0.1,0.1,weave"] * 3, "11,-1,20,0.1,0.1"]))
    assert read_eigenvalues(path).mode == ("weave", "weave", "weave", "")


@pytest.mark.parametrize("row, expected", [
    ("10,x,20,0.1,0.1,weave", "line 7, column real: 'x' is not a number"),
    ("10,inf,20,0.1,0.1,weave", "line 7, column real: 'inf' is not finite"),
    ("10,-1,20,0.1,0,weave", "line 7, imag_se is 0; expected a standard error above zero"),
    ("10", "line 7, column real: '' is not a number"),
])  # fmt: skip
def test_a_message_has_the_line_of_the_file(row, expected, tmp_path):
    path = tmp_path / "eigenvalues.csv"
    good = "10,-1,20,0.1,0.1,weave"
    path.write_text("\n".join(["# of a ride", "", LAST, good, "# second run", good, row, good, good]))
    with pytest.raises(InputError, match=expected):
        read_eigenvalues(path)


@pytest.mark.parametrize("oscillates", [True, False])
def test_the_next_measurement_weighs_each_part_by_its_own_error(oscillates, tmp_path):
    """Rivals are the vehicle with two steering dampers; the eigenvalues of each follow from its own matrices."""
    vehicle, mode = motorcycles.load("sharp_1971"), "weave" if oscillates else "capsize"
    errors, path = (0.2, 0.05), tmp_path / "eigenvalues.csv"
    speeds = np.linspace(10.0, 20.0, 5)
    shown = [modes(over_speed(ridden(vehicle)), np.array([v]))[mode].eigenvalue[0] for v in speeds]
    path.write_text("\n".join([EXAMPLE, *(f"{v},{mode},{x.real},{oscillates * abs(x.imag)},{errors[0]},{errors[1]}"
                                           for v, x in zip(speeds, shown, strict=True))]))  # fmt: skip
    experiment = vehicle_experiment(vehicle)
    run = with_mode_names(read_eigenvalues(path), experiment)
    damping = next(e for e in vehicle_effects(vehicle) if e.family == "steer_damping" and e.prior is None)
    model = EigenvalueModel(experiment).with_added_effects(damping)
    rivals = []
    for size in (1.0, 4.0):
        start = model.start()
        start[model.names.index("vehicle.steer_damping.damping")] = size
        rivals.append(fit(model, [run], start, frozen=range(len(start))))
    tied = [Candidate(damping, found, 0.0, 0.0) for found in rivals]
    proposed = next_measurement(Verdict("tied", rivals[0], rivals[0], tied=tied), experiment)
    one, other = (
        modes(over_speed(ridden(vehicle.with_effects(damping()).with_values(**{"steer_damping.damping": size}))),
              np.array([proposed["speed"]]))[mode].eigenvalue[0]
        for size in (1.0, 4.0)
    )  # fmt: skip
    difference = one - other
    expected = (difference.real / errors[0]) ** 2 + oscillates * (difference.imag / errors[1]) ** 2
    assert proposed["expected_delta_chi2"] == pytest.approx(expected, rel=1e-6)
    said = "0.2 1/s of the real and 0.05 1/s of the imaginary part" if oscillates else "0.2 1/s"
    assert f"with a standard error of {said} as before" in proposed["sentence"]


@pytest.mark.slow
def test_a_base_with_a_very_small_parameter_is_fitted_from_its_values(tmp_path):
    """Coefficients such as those of a relaxation length per stiffness are far below 1e-6 in their units."""
    vehicle = motorcycles.load("sharp_1971", front_product_of_inertia=1e-9)
    write(tmp_path / "eigenvalues.csv", spectrum(SHARP, SPEEDS, {}), SPEEDS, np.random.default_rng(0), 0.01)
    experiment = vehicle_experiment(vehicle)
    model = EigenvalueModel(experiment)
    found = fit(model, [with_mode_names(read_eigenvalues(tmp_path / "eigenvalues.csv"), experiment)], model.start())
    place = model.base.index("vehicle.front_product_of_inertia")
    # The data do not depend on it: it keeps its value, and not the least value of other parameters.
    assert np.exp(found.x[place]) == pytest.approx(1e-9, rel=1e-3)


def test_repeated_rows_of_a_mode_are_one_eigenvalue(tmp_path):
    """Each row twice, with errors of both signs: both have the prediction of the single row."""
    once = read_eigenvalues(measured(tmp_path, {}, seed=3))
    rows = [EXAMPLE]
    for shift in (0.02, -0.02):
        rows += [f"{v},{m},{x.real + shift},{x.imag},{s},{w}" for v, m, x, s, w in zip(
            once.over, once.mode, once.value, once.real_error, once.imag_error, strict=True)]  # fmt: skip
    (tmp_path / "twice.csv").write_text("\n".join(rows))
    experiment = vehicle_experiment(motorcycles.load("sharp_1971"))
    model = EigenvalueModel(experiment)

    def predicted(run):
        named = with_mode_names(run, experiment)
        parts = model.reduced(named, model.start())[0] * named.deviation
        return parts[: len(run.value)]  # the real parts

    np.testing.assert_allclose(predicted(read_eigenvalues(tmp_path / "twice.csv")), np.tile(predicted(once), 2), rtol=1e-12)
