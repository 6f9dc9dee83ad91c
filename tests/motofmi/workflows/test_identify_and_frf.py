"""`estimate_frf` and `identify` from Python: recordings as objects, results that other functions take, and what is written."""

from dataclasses import replace

import numpy as np
import pytest

import motofmi as mf
from fmus.support.files import writable
from motofmi.cli.main import main
from motofmi.frequency_response.excitation import sweep
from motofmi.recordings.reading import write_recording
from motofmi.virtual_rig.simulated_rig import steer_test
from rider_fmu import riders
from tests.pages import Page, assert_is_a_report, assert_works_in_a_browser, needs_browser

RIDER = "5_2011"
BAR = 0.125  # kg.m2


@pytest.fixture(scope="module")
def runs():
    return [steer_test(riders.load(RIDER), BAR, sweep(duration=60), seed=seed, oversampling=2) for seed in range(2)]


@pytest.fixture(scope="module")
def frf(runs):
    return mf.estimate_frf(runs)


@pytest.fixture(scope="module")
def fit(frf):
    return mf.identify(frf, band=(1.0, 12.0))


@pytest.mark.slow
def test_one_object_for_one_run_and_for_several(frf, runs):
    one = mf.estimate_frf(runs[0])
    assert one.runs == [runs[0].name] and len(frf.runs) == 2
    for found in (one, frf):
        n = len(found.frequency)
        assert (
            found.inertance.shape
            == found.standard_deviation.shape
            == found.phase_standard_deviation.shape
            == found.coherence.shape
            == (n,)
        )
        assert len(found.to_dataframe()) == n
    assert set(one.to_dict()["standard_deviation_of"]) == {"estimate"} and set(
        frf.to_dict()["standard_deviation_of"]
    ) == {"runs"}


def test_an_frf_goes_to_python_control(frf):
    there = frf.to_control()
    np.testing.assert_allclose(there(2j * np.pi * frf.frequency), frf.inertance)
    assert (there.input_labels, there.output_labels) == (["steer_torque"], ["steer_acceleration"])


@pytest.mark.slow
def test_results_show_themselves(frf, fit, tmp_path):
    for result, count in ((frf, 2), (fit, 3)):
        axes = result.plot()
        assert len(axes) == count and "[" in axes[-1].get_xlabel() and all("[" in a.get_ylabel() for a in axes)
        assert (
            "<table>" in result._repr_html_() and "data:image/png" in result._repr_html_() and len(repr(result)) < 400
        )
        assert "<iframe" in result.show()._repr_html_()


@pytest.fixture(scope="module")
def reports(runs, tmp_path_factory):
    """The reports of the FRF and of the identified rider, from files."""
    folder = tmp_path_factory.mktemp("reports")
    files = [str(folder / f"run_{k}.csv") for k in range(len(runs))]
    for run, file in zip(runs, files, strict=True):
        write_recording(run, file)
    found = {}
    for command in ("frf", "identify"):
        found[command] = folder / f"{command}.html"
        assert main([command, *files, "--report", str(found[command]), "--json", str(folder / f"{command}.json")]) == 0
    return found


@pytest.mark.slow
def test_the_reports_hold_the_numbers_of_the_results(reports, frf):
    page = assert_is_a_report(reports["frf"], inputs=2, command="motofmi frf", pictures=3)
    assert [name for name in ("Coherence", "Nyquist plane", "Bands of frequency") if name not in page.text] == []
    assert page.text.count(f"{abs(frf.inertance[0]):.4g}") >= 1
    page = assert_is_a_report(reports["identify"], inputs=2, command="motofmi identify", pictures=4)
    words = ("Residuals", "Correlations of the errors", "Combinations that the data determine", "95 % interval", "arm stiffness")
    assert [name for name in words if name not in page.text] == [] and "identify.json" in page.source


@pytest.mark.slow
def test_a_rejected_model_is_said_first(runs, tmp_path):
    """The fit of one rider to runs of which one has twice the torque."""
    wrong = replace(runs[1], columns=runs[1].columns | {"steer_torque": 1.3 * runs[1]["steer_torque"] + 5e3 * runs[1]["steer_angle"] ** 3})
    found = mf.identify([wrong], method="weighted")
    page = Page(found.report(tmp_path / "report.html"))
    if found.fit.reduced_chi_square > 2:
        assert "does not explain the data" in page.text and "motofmi gap" in page.text.partition("How this report")[0]


@pytest.mark.slow
@needs_browser
def test_the_reports_work_in_a_browser(reports):
    for path in reports.values():
        assert_works_in_a_browser(path)


def test_the_identified_rider_is_a_component_that_other_functions_take(fit, tmp_path):
    assert (
        fit.rider.values["arm_stiffness"]
        == fit.parameters["arm_stiffness"]["value"]
        == pytest.approx(riders.load(RIDER).values["arm_stiffness"], rel=0.1)
    )
    own, loaded = (
        mf.modes("sharp_1971", rider, speed=[40.0])["weave"].eigenvalue
        for rider in (fit.rider, mf.rider(fit.save(tmp_path / "mine.toml")))
    )
    np.testing.assert_allclose(own, loaded, rtol=1e-9)
    assert set(fit.to_dataframe()["name"]) == {*fit.parameters, *fit.derived}


@pytest.mark.slow
def test_a_model_that_does_not_explain_the_data_is_said(fit, runs):
    assert not [w for w in fit.warnings if "chi-square" in w]
    rate = np.gradient(runs[0]["steer_angle_command"], runs[0].time)
    rubbing = replace(
        runs[0], columns={**runs[0].columns, "steer_torque": runs[0]["steer_torque"] + 3.0 * np.sign(rate)}
    )
    for method in ("weighted", "nyquist"):
        found = mf.identify(rubbing, method=method, starts=1)
        (warning,) = [w for w in found.warnings if "chi-square" in w]
        assert "does not explain the data" in warning and "motofmi gap" in warning


@pytest.mark.slow
def test_figures_have_the_name_that_was_given(runs, tmp_path, capsys):
    write_recording(runs[0], tmp_path / "run.csv")
    assert (
        main(
            [
                "identify",
                str(tmp_path / "run.csv"),
                "--starts",
                "1",
                "--plot",
                str(tmp_path / "fit.png"),
                "--report",
                str(tmp_path / "fit.html"),
            ]
        )
        == 0
    )
    said = capsys.readouterr().out
    assert sorted(p.name for p in tmp_path.iterdir()) == ["fit.html", "fit.png", "run.csv"]
    assert all(f"written: {tmp_path / name}" in said for name in ("fit.png", "fit.html"))


@pytest.mark.parametrize("option", ["--plot", "--report", "--out"])
@pytest.mark.parametrize("command", ["frf", "identify"])
def test_outputs_that_cannot_be_written_are_noticed_before_the_recordings_are_read(command, option, tmp_path, capsys):
    if (command, option) == ("frf", "--out"):
        return
    (tmp_path / "file").write_text("")
    path = tmp_path / "file" / {"--plot": "a.png", "--report": "a.html", "--out": "a.toml"}[option]
    assert main([command, "no_such_recording.csv", option, str(path)]) == 2
    assert f"cannot write {path}: {tmp_path / 'file'} is not a folder" in capsys.readouterr().err


def test_writable_makes_nothing(tmp_path):
    assert writable(tmp_path / "new" / "folder" / "file.txt") == tmp_path / "new" / "folder" / "file.txt"
    assert not list(tmp_path.iterdir())
    with pytest.raises(mf.InputError, match=f"cannot write {tmp_path}: it is a folder"):
        writable(tmp_path)


@pytest.mark.parametrize(("arguments", "message"), [
    ({"method": "nyquis"}, "did you mean 'nyquist'"), ({"bounds": {"arm_dampng": (1, 2)}}, "did you mean 'arm_damping'"), ({"starts": 0}, "starts 0 is too small"),
    ({"band": (5, 1)}, "lower one first"), ({"width": -1.0}, "not positive"), ({"rig": "nowhere.json"}, "cannot read nowhere.json"), ({"recordings": []}, "no recordings"),
])  # fmt: skip
def test_what_cannot_be_used(arguments, message, runs):
    with pytest.raises(mf.InputError, match=message):
        mf.identify(**{"recordings": runs[0], **arguments})
