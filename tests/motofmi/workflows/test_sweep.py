"""Studies: every run against the same run by itself, validation before anything runs, failures with their reasons."""

import json
import re
import sys

import numpy as np
import pytest

import motofmi as mf
from fmus.support.errors import InputError, MissingToolError
from motofmi.cli.main import main
from motofmi.workflows.modes import state_space
from tests.motofmi.json_schemas import check_against_schema

pytest.importorskip("zarr", reason="the extra motofmi[scale] is not installed")
pytest.importorskip("pyarrow", reason="the extra motofmi[scale] is not installed")


@pytest.fixture(scope="module")
def modes(tmp_path_factory):
    """The ten published riders with two values of trail on one vehicle, alone and with a damper."""
    return mf.sweep(device=["none", "damper:7.5"], speed=[10.0, 30.0, 50.0], design="members",
                    set={"rider": "~riders_2011", "trail": [0.10, 0.116]}, out=tmp_path_factory.mktemp("out") / "modes",
                    workers=1)  # fmt: skip


@pytest.mark.slow
def test_each_run_is_that_of_the_rider_by_itself(modes):
    chosen = modes.dataset["eigenvalue"].sel(rider=3, device="damper:7.5", trail=0.10).squeeze("vehicle")
    alone = mf.modes("sharp_1971", ["rider:3_2011", "damper:7.5"], [10.0, 30.0, 50.0], set={"trail": 0.10})
    for mode in ("weave", "wobble", "capsize", "rear_wobble", "rider_wobble"):
        np.testing.assert_allclose(chosen.sel(mode=mode).values, alone[mode].eigenvalue, rtol=1e-9)
    row = modes.table.query("rider == 3 and device == 'damper:7.5' and trail == 0.10").iloc[0]
    # Both locate the ends of bands to 0.01 m/s; three speeds do not show where a band begins between them.
    (band,) = alone.unstable["weave"]
    assert (row["weave_from"], row["weave_to"]) == pytest.approx(band, abs=0.05)


@pytest.mark.slow
def test_dimensions_have_names_and_units(modes):
    data = modes.dataset
    assert dict(data.sizes) == {"vehicle": 1, "device": 2, "rider": 10, "trail": 2, "mode": 5, "speed": 3}
    assert (data["speed"].attrs["units"], data["trail"].attrs["units"], data["eigenvalue"].attrs["units"]) == (
        "m/s",
        "m",
        "1/s",
    )
    assert data["rider.arm_stiffness"].values[0] == mf.rider("1_2011").values["arm_stiffness"]
    assert modes.runs == 40 and modes.failed == 0
    assert mf.open_study(modes.folder).to_dict() == modes.to_dict()


@pytest.mark.slow
def test_the_share_of_unstable_riders_is_counted(modes):
    unstable = [mf.modes("sharp_1971", f"rider:{k}_2011", [30.0], set={"trail": 0.10})["weave"].eigenvalue[0].real > 0
                for k in range(1, 11)]  # fmt: skip
    share = modes.share_unstable("weave").sel(device="none", trail=0.10, speed=30.0)
    assert float(share.squeeze()) == pytest.approx(np.mean(unstable))
    with pytest.raises(InputError, match="unknown mode 'weve', did you mean 'weave'"):
        modes.share_unstable("weve")


@pytest.mark.slow
def test_the_report_is_one_file_with_its_figures(modes, tmp_path):
    text = modes.report(tmp_path / "report.html").read_text("utf-8")
    for part in ("Stability", "Quantiles over the runs", "Sensitivities", "Worst runs", "share of runs unstable",
                 "damped frequency", "standardised rank regression"):  # fmt: skip
        assert part in text
    assert not re.search(r"""(src|href)=["']?https?://""", text)


@pytest.mark.slow
def test_transfer_functions_of_devices_add_up(tmp_path):
    found = mf.sweep(kind="frf", device=["rider:2_2011,damper:5"], frequency=[1.0, 6.0],
                     set={"arm_damping": [15.0, 20.0]}, out=tmp_path / "frf", workers=1)  # fmt: skip
    for damping in (15.0, 20.0):
        parts = [mf.transfer_functions("rider:2_2011", [1.0, 6.0], set={"arm_damping": damping}),
                 mf.transfer_functions("damper:5", [1.0, 6.0])]  # fmt: skip
        ours = found.dataset["handlebar_torque"].sel(arm_damping=damping).values.ravel()
        np.testing.assert_allclose(ours, sum(part["handlebar_torque"] for part in parts), rtol=1e-12)


@pytest.mark.slow
def test_linear_systems_have_the_names_of_their_signals(tmp_path):
    found = mf.sweep(kind="linear_systems", device=["none", "rider:mean_2011"], speed=[20.0, 30.0],
                     out=tmp_path / "linear", workers=1).dataset  # fmt: skip
    alone = state_space("sharp_1971", "rider:mean_2011", [20.0, 30.0])
    chosen = found.sel(device="rider:mean_2011").squeeze("vehicle")
    at = {"state_rate": list(alone.states), "state": list(alone.states)}
    np.testing.assert_allclose(chosen["A"].sel(at).values, alone.A, rtol=1e-12)
    absent = found["A"].sel(device="none", state="device.torso_angle")
    assert np.isnan(absent.values).all()  # the motorcycle without a rider has no torso


@pytest.mark.slow
def test_a_cosimulation_is_that_of_the_run_by_itself(tmp_path):
    given = {"duration": 1.0, "initial": {"steer_rate": 0.5}}
    found = mf.sweep(kind="cosimulation", device=["none", "rider:2_2011"], set={"steering_damping": [0.0, 5.0]},
                     speed=[30.0], coupling="gauss_seidel", out=tmp_path / "runs", workers=1, **given)  # fmt: skip
    alone = mf.cosimulate("sharp_1971", "rider:2_2011", speed=30.0, set={"steering_damping": 5.0}, coupling="gauss_seidel",
                          **given)  # fmt: skip
    ours = found.dataset["vehicle.steer_angle"].sel(device="rider:2_2011", steering_damping=5.0).values.ravel()
    np.testing.assert_array_equal(ours, alone["vehicle.steer_angle"][::10])


@pytest.mark.slow
def test_couplings_and_steps_are_dimensions(tmp_path):
    given = {"duration": 0.5, "initial": {"steer_rate": 0.5}}
    couplings, steps = ["jacobi", "gauss_seidel"], [0.001, 0.002]
    found = mf.sweep(kind="cosimulation", device="rider:2_2011", speed=[30.0], coupling=couplings, step=steps,
                     out=tmp_path / "runs", workers=1, **given)  # fmt: skip
    steered = found.dataset["vehicle.steer_angle"].squeeze()
    assert steered.dims == ("coupling", "step", "time") and found.dataset["step"].attrs["units"] == "s"
    assert found.table["coupling"].tolist() == ["jacobi", "jacobi", "gauss_seidel", "gauss_seidel"]
    for coupling in couplings:
        for step in steps:
            alone = mf.cosimulate("sharp_1971", "rider:2_2011", speed=30.0, coupling=coupling, step=step, **given)
            kept = alone["vehicle.steer_angle"][:: round(0.01 / step)]
            np.testing.assert_array_equal(steered.sel(coupling=coupling, step=step).values, kept)


@pytest.mark.slow
def test_a_run_that_fails_is_recorded_and_the_others_go_on(tmp_path):
    found = mf.sweep(kind="cosimulation", device=["damper:1"], speed=[30.0], step=0.02, duration=1.0,
                     set={"damping": [1.0, 2000.0]}, coupling="jacobi", initial={"steer_rate": 0.5},
                     out=tmp_path / "runs", workers=1)  # fmt: skip
    assert (found.runs, found.failed) == (2, 1)
    (reason,) = found.table.query("status == 'failed'")["reason"]
    assert "the signals diverge" in reason and "smaller step" in reason
    assert np.isnan(found.dataset["vehicle.steer_angle"].sel(damping=2000.0)).all()
    assert np.isfinite(found.dataset["vehicle.steer_angle"].sel(damping=1.0)).all()


@pytest.mark.parametrize(("arguments", "message"), [
    ({"vehicle": "sharp_1917"}, "unknown motorcycle 'sharp_1917', did you mean 'sharp_1971'"),
    ({"kind": "mods"}, "unknown kind of study 'mods', did you mean 'modes'"),
    ({"sped": 3}, "unknown key of a study of kind modes 'sped', did you mean 'speed'"),
    ({"set": {"trial": "0.1:0.2:3"}}, "unknown parameter 'trial', did you mean 'trail'"),
    ({"set": {"trail": "0.1:0.2:0.05"}}, "the third number is the number of values"),
    ({"set": {"rider": "~riders_2010"}}, "unknown population 'riders_2010', did you mean 'riders_2011'"),
    ({"set": {"trail": "~riders_2011"}}, "neither a range A:B nor a population"),
    ({"set": {"rider": "~riders_2011"}, "design": "sobel"}, "unknown design 'sobel', did you mean 'sobol'"),
    ({"set": {"rider": "~riders_2011"}, "device": "rider:mean_2011"}, "cannot both hold the handlebar"),
    ({"set": {"steering_damping": [0.0, -1.0]}}, "is outside its bounds"),
    ({"speed": [30.0, 20.0]}, "ascending"),
    ({"device": ["none", "none"]}, "the device 'none' is given twice"),
    ({"kind": "frf", "speed": None}, "device 'none' has no transfer functions"),
    ({"kind": "cosimulation", "coupling": ["jacobi", "jacoby"]}, "unknown coupling 'jacoby', did you mean 'jacobi'"),
    ({"kind": "cosimulation", "step": [0.001, 0.001]}, "step has the same value twice"),
    ({"workers": 0}, "expected 1 or more"),
])  # fmt: skip
def test_what_cannot_be_run_is_refused_before_anything_is_written(tmp_path, arguments, message):
    with pytest.raises(InputError, match=message):
        mf.sweep(**{"speed": [30.0], "out": tmp_path / "study", **arguments})
    assert not (tmp_path / "study").exists()


@pytest.mark.slow
def test_without_dask_the_processes_of_this_machine_compute(tmp_path, monkeypatch):
    for name in ("dask", "distributed", "SALib"):
        monkeypatch.setitem(sys.modules, name, None)  # as if it were not installed
    given = {"speed": [20.0, 40.0], "set": {"trail": "0.1:0.12:3"}}
    found = mf.sweep(out=tmp_path / "study", workers=2, **given)
    assert (found.runs, found.failed) == (3, 0)
    with pytest.raises(MissingToolError, match=r"--scheduler needs Dask: pip install 'motofmi\[scale\]'"):
        mf.sweep(out=tmp_path / "other", scheduler="tcp://127.0.0.1:1", **given)
    assert not (tmp_path / "other").exists()


@pytest.mark.parametrize("name", ["zarr", "pyarrow.parquet"])
def test_without_the_store_the_extra_is_named(tmp_path, monkeypatch, name):
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingToolError, match=r"pip install 'motofmi\[scale\]'"):
        mf.sweep(speed=[20.0, 40.0], out=tmp_path / "study")
    assert not (tmp_path / "study").exists()


@pytest.mark.slow
def test_the_command_plans_runs_and_reports(tmp_path, capsys):
    study = tmp_path / "study.toml"
    study.write_text('device = ["damper:0", "damper:5"]\nspeed = "20:40:10"\n[set]\ntrail = "0.1:0.12:2"\n')
    out = tmp_path / "out"
    assert main(["sweep", str(study), "--out", str(out), "--workers", "1", "--plan"]) == 0
    assert capsys.readouterr().out.startswith(
        "4 runs of kind modes (1 vehicle x 2 device x 2 trail) in 1 chunks: about "
    )
    assert not out.exists()
    assert main(["sweep", str(study), "--out", str(out), "--workers", "1", "--report", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    check_against_schema("sweep", found)
    assert (found["runs"], found["failed"], found["report"]) == (4, 0, str(out / "report.html"))
    assert main(["sweep", str(study), "--set", "trail", "--out", str(out)]) == 2
    assert "neither NAME=VALUES nor NAME~POPULATION" in capsys.readouterr().err


@pytest.mark.slow
def test_the_parameters_of_an_fmu_are_set_from_run_to_run(tmp_path):
    """Those of an archive without its source, by name, in the study of the modes and in that of co-simulations."""
    archive = mf.build("damper:7.5", tmp_path).path
    damping = [2.0, 8.0]
    modes = mf.sweep(device=str(archive), speed=[20.0, 40.0], set={"damping": damping}, out=tmp_path / "modes", workers=1)
    runs = mf.sweep(kind="cosimulation", device=str(archive), speed=30.0, set={"damping": damping}, out=tmp_path / "runs",
                    workers=1, duration=0.5, initial={"steer_rate": 1.0})  # fmt: skip
    for value in damping:
        alone = mf.modes("sharp_1971", f"damper:{value}", [20.0, 40.0])
        found = modes.dataset["eigenvalue"].sel(damping=value, mode="wobble").squeeze()
        np.testing.assert_allclose(found.values, alone["wobble"].eigenvalue, rtol=1e-9)
        run = mf.cosimulate("sharp_1971", f"damper:{value}", speed=30, duration=0.5, initial={"steer_rate": 1.0})
        signal = runs.dataset["vehicle.steer_angle"].sel(damping=value).squeeze()
        # both use the coupling and step that are found for them; their errors are below the tolerance of 1 %
        wanted = np.interp(signal.time.values, run["time"], run["vehicle.steer_angle"])
        np.testing.assert_allclose(signal.values, wanted, atol=1e-2 * np.abs(wanted).max())
    with pytest.raises(InputError, match=r"device: damping = -1 N\.m\.s/rad is outside its bounds \[0, 10000\]"):
        mf.sweep(device=str(archive), set={"damping": -1.0}, out=tmp_path / "refused", workers=1)
