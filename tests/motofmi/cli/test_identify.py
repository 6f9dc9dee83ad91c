"""`frf` and `identify`: from CSV files to a rider that every other command takes."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from fmus.composition.value_files import component_from, read_values
from fmus.support.errors import InputError
from motofmi.cli.main import main
from motofmi.frequency_response.excitation import sweep
from motofmi.recordings.reading import read_recording, write_recording
from motofmi.scenarios import which_test_tells_most_about_the_rider as which_test
from motofmi.virtual_rig.simulated_rig import steer_test
from motofmi.workflows.measured_rider import PARAMETERS, table_spread
from rider_fmu import COMPONENTS, PassiveRider, riders
from rider_fmu.two_degree_of_freedom import derived
from tests.motofmi.json_schemas import check_against_schema

DERIVED = {"nu1", "nu2", "zeta1", "zeta2", "nu_t", "zeta_t", "added_steer_inertia"}


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Three noisy sweeps of rider 5 as files, with a rig.json."""
    folder = tmp_path_factory.mktemp("runs")
    for k in range(3):
        run = steer_test(riders.load("5_2011"), 0.1266, sweep(duration=100), seed=k, oversampling=2)
        write_recording(run, folder / f"run_{k}.csv")
    (folder / "rig.json").write_text('{"handlebar_inertia": {"value": 0.124, "unit": "kg.m2"}}')
    return [str(folder / f"run_{k}.csv") for k in range(3)]


def answer(capsys, *words):
    status = main([*words, "--json", "-"])
    out, err = capsys.readouterr()
    assert status == 0, err
    found = json.loads(out)
    check_against_schema(words[0], found)
    return found


@pytest.mark.slow
def test_written_recordings_are_what_was_measured(runs):
    run = steer_test(riders.load("5_2011"), 0.1266, sweep(duration=100), seed=0, oversampling=2)
    np.testing.assert_allclose(read_recording(runs[0])["steer_torque"], run["steer_torque"], rtol=1e-5)


@pytest.mark.slow
def test_frf(runs, capsys, tmp_path):
    result = answer(capsys, "frf", *runs, "--plot", str(tmp_path / "frf.svg"), "--report", str(tmp_path / "frf.html"))
    count = len(result["frequency"])
    assert count == 47 and {
        len(result[k]) for k in ("inertance", "standard_deviation", "coherence", "receptance", "impedance")
    } == {count}
    modulus = np.hypot(*np.transpose(result["inertance"]))
    frequency = np.array(result["frequency"])
    peak, trough = frequency[np.argmax(modulus[:20])], frequency[10 + np.argmin(modulus[10:])]
    # 2011, Sect. 3.1: a peak at about 1.5 to 2.5 Hz, a minimum (for this rider's k_a and I_t at 7 Hz), then increasing
    # values
    assert 1.5 <= peak <= 2.5 and 5 <= trough <= 8 and modulus[-1] > modulus.min()
    assert (
        "svg" in (tmp_path / "frf.svg").read_text()[:500]
        and "Frequency response" in (tmp_path / "frf.html").read_text()
    )
    single = answer(capsys, "frf", runs[0], "--band", "2:8", "--reference", "steer_torque")
    assert (
        single["frequency"][0] == 2
        and single["frequency"][-1] == 8
        and set(single["standard_deviation_of"]) == {"estimate"}
    )


@pytest.mark.slow
def test_the_table_of_an_frf_names_every_column_once(runs, capsys):
    for files, title in (
        (runs[:1], "one run; sd: standard error of the estimate"),
        (runs[:2], "mean of 2 runs; sd: standard deviation over the runs"),
    ):
        assert main(["frf", *files, "--band", "4:5"]) == 0
        first, heading, *rows = capsys.readouterr().out.splitlines()
        assert first == f"inertance, {title}"
        columns = re.split(r"\s{2,}", heading.strip())
        assert len(set(columns)) == len(columns) == 6 and all(column.endswith("]") for column in columns)
        assert [row.split()[0] for row in rows[:5]] == ["4.00", "4.25", "4.50", "4.75", "5.00"]


@pytest.mark.slow
def test_identify_gives_the_rider_with_its_uncertainty(runs, capsys, tmp_path):
    result = answer(capsys, "identify", *runs, "--out", str(tmp_path / "mine.toml"))
    assert set(result["parameters"]) == set(PARAMETERS) and set(result["derived"]) == DERIVED
    assert set(result["residual"]) == {"radius", "phase_deg"}
    truth = {"steer_inertia": 0.1266, **riders.load("5_2011").values}
    for name, entry in result["parameters"].items():
        assert abs(entry["value"] - truth[name]) < 4 * entry["standard_error"], name
        assert 0 < entry["standard_error"] < 0.1 * entry["value"]
    assert result["derived"]["added_steer_inertia"]["value"] == pytest.approx(
        result["parameters"]["steer_inertia"]["value"] - 0.124
    )
    rider = component_from(read_values(tmp_path / "mine.toml"), COMPONENTS, "mine", "mine.toml")
    assert isinstance(rider, PassiveRider)
    assert rider.values["arm_stiffness"] == result["parameters"]["arm_stiffness"]["value"]
    assert rider.standard_error["waist_damping"] == pytest.approx(
        result["parameters"]["waist_damping"]["standard_error"]
    )
    assert rider.correlation["arm_damping"]["arm_stiffness"] == pytest.approx(result["correlation"][4][2], abs=1e-4)
    assert rider.with_values(arm_damping=1.0).standard_error == rider.standard_error


@pytest.mark.slow
def test_other_commands_take_the_identified_rider(runs, capsys, tmp_path):
    file = str(tmp_path / "mine.toml")
    answer(capsys, "identify", runs[0], "--out", file)
    modes = answer(capsys, "modes", "--device", file, "--speed", "40")
    published = answer(capsys, "modes", "--device", "rider:5_2011", "--speed", "40")
    # one 100 s run fixes the parameters within 1 %, the weave frequency within less
    assert modes["modes"]["weave"]["frequency"][0] == pytest.approx(
        published["modes"]["weave"]["frequency"][0], rel=0.01
    )


@pytest.mark.slow
@pytest.mark.parametrize("method", ["nyquist", "amplitude"])
def test_the_papers_methods(runs, capsys, method):
    result = answer(
        capsys, "identify", *runs, "--method", method, "--bound", "steer_inertia=0.124:0.2", "--band", "1:12"
    )
    assert result["method"] == method
    assert result["parameters"]["arm_stiffness"]["value"] == pytest.approx(1358.2, rel=0.2)


@pytest.mark.slow
def test_errors_of_derived_quantities_agree_with_draws(runs, capsys):
    """To first order, against the spread of the quantities of a bootstrap's own parameters."""
    result = answer(capsys, "identify", runs[0], "--bootstrap", "60")
    for name, entry in result["bootstrap"].items():
        assert entry["standard_error"] == pytest.approx(result["parameters"][name]["standard_error"], rel=0.45)
        assert entry["interval_95"][0] < result["parameters"][name]["value"] < entry["interval_95"][1]
    nu_t, arms = result["derived"]["nu_t"], result["parameters"]["arm_stiffness"]
    # nu_t goes with the square root of k_a + k_t over I_t, known better than either
    assert nu_t["standard_error"] < nu_t["value"] * arms["standard_error"] / arms["value"]


@pytest.mark.slow
def test_populations(runs, capsys, tmp_path):
    drawn = answer(capsys, "identify", "--population", "5", "--out", str(tmp_path / "spread"))["population"]
    fitted = answer(capsys, "identify", runs[0], "--population", "5", "--out", str(tmp_path / "fitted"))["population"]
    for paths in (drawn, fitted):
        stiffness = [
            component_from(read_values(p), COMPONENTS, "", str(p)).values["arm_stiffness"] for p in map(Path, paths)
        ]
        assert len(set(stiffness)) == 5
    # 2011, Table 2, last row: sigma/mu of the ten riders; 100,000 draws of a log-normal scatter by 2 %
    spread = table_spread(100_000)
    np.testing.assert_allclose(
        spread.std(axis=0) / spread.mean(axis=0), [0.3220, 0.2417, 0.3790, 0.3568, 0.5505, 0.4457], rtol=0.02
    )


@pytest.mark.slow
def test_mean_rider_of_several(runs, capsys):
    result = answer(capsys, "identify", *runs, "--mean", "--band", "1:12")
    assert result["parameters"]["torso_inertia"]["value"] == pytest.approx(0.5085, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["identify"], "needs recordings, or --population"),
        (["identify", "--population", "3"], "needs --out FOLDER"),
        (["identify", "RUN", "--out", "mine.txt"], "ends in .toml"),
        (["identify", "RUN", "--bound", "mass=1:2"], "no such parameter (valid: steer_inertia"),
        (["identify", "RUN", "--bound", "arm_damping=5"], "is not LOW:HIGH"),
        (["identify", "RUN", "--starts", "0"], "--starts 0 is too small"),
        (["identify", "nowhere.csv"], "nowhere.csv"),
        (["frf", "RUN", "--band", "12:1"], "is not LOW:HIGH"),
        (["frf", "RUN", "--width", "-1"], "is not positive"),
        (["frf", "RUN", "--width", "0.01"], "cannot give bands of 0.01 Hz"),
        (["frf", "RUN", "--band", "13:20"], "nothing was excited between 13 and 20 Hz"),
        (["frf", "RUN", "--plot", "frf.gif"], ".png, .svg, .pdf"),
        (["frf", "RUN", "--map", "steer_angle"], "is not COLUMN=VARIABLE"),
        (["frf", "RUN", "--rig", "nowhere.json"], "nowhere.json"),
    ],
)
def test_bad_input_is_one_line_and_status_2(words, message, runs, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main([runs[0] if w == "RUN" else w for w in words]) == 2
    out, err = capsys.readouterr()
    assert message in err and err.count("\n") == 1 and not out
    assert not list(tmp_path.iterdir())


def test_value_files_refuse_what_makes_no_sense(tmp_path):
    def load(text):
        (tmp_path / "rider.toml").write_text('component = "PassiveRider"\n' + text)
        return component_from(read_values(tmp_path / "rider.toml"), COMPONENTS, "", "rider.toml")

    with pytest.raises(InputError, match="unknown key of arm_stiffness 'standard_eror', did you mean 'standard_error'"):
        load("[parameters]\narm_stiffness = { value = 1000, standard_eror = 1 }")
    with pytest.raises(InputError, match="unknown parameter with a standard_error"):
        load(
            "[parameters]\narm_stiffness = { value = 1000, standard_error = 1 }\n[correlation.arm_stiffness]\narm_damping = 0.5"
        )
    with pytest.raises(InputError, match="expected a number from -1 to 1"):
        load(
            "[parameters]\narm_stiffness = { value = 1000, standard_error = 1 }\n[correlation.arm_stiffness]\narm_stiffness = 5"
        )


def test_undamped_frequencies_are_those_of_the_mass_and_stiffness_matrices():
    """2008, eqs 3 and 4 written as matrices, the cross inertia among them."""
    rider = riders.load("3_2008").with_values(cross_inertia=0.05)
    mass = np.array([[0.252, 0.05], [0.05, 0.664]])
    stiffness = np.array([[796, -796], [-796, 796 + 118.0]])
    nu = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)) / (2 * np.pi)
    found = derived(rider, 0.252, 0.12)
    assert (found["nu1"], found["nu2"]) == pytest.approx(tuple(nu), rel=1e-9)


@pytest.mark.slow
def test_which_test_tells_most():
    found = which_test.run()
    truth = np.array([0.125, *(riders.load("mean_2011").values[n] for n in PARAMETERS[1:])])
    for identification in found.values():
        assert np.all(np.abs(identification.values - truth) < 4 * identification.standard_error)
    section = which_test.section(found)
    # twice the amplitude of the sweep, and no time spent above 8.5 Hz: the stepped sine knows the low-frequency
    # parameters best
    assert "stepped sine, 4 deg (2008) leaves the smallest" in section.paragraphs[0] and section.figures
