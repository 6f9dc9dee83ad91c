"""Batches of recordings: one row for each test, reasons for files that cannot be used, resumed where they ended."""

import re
import shutil

import numpy as np
import pandas as pd
import pytest

import motofmi as mf
from fmus.support.errors import InputError
from motofmi.cli.main import main
from motofmi.frequency_response.excitation import sweep
from motofmi.recordings.reading import write_recording
from motofmi.virtual_rig.simulated_rig import steer_test
from rider_fmu import riders
from tests.simulators.hidden_joint import joint_run

pytest.importorskip("zarr", reason="the extra motofmi[scale] is not installed")

NAMES = ["1_2011", "5_2011"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Sweeps of two riders, and a file that is cut off."""
    folder = tmp_path_factory.mktemp("recordings")
    for name in NAMES:
        run = steer_test(riders.load(name), 0.125 + riders.load(name).values["added_steer_inertia"], sweep(), seed=1,
                         oversampling=2)  # fmt: skip
        write_recording(run, folder / f"rider_{name}.csv")
    (folder / "broken.csv").write_text("time [s],steer_angle [rad],steer_torque [N.m]\n0.0,0.1,x\n")
    (folder / "notes.md").write_text("no recording")
    return folder


@pytest.fixture(scope="module")
def found(folder, tmp_path_factory):
    return mf.batch("identify", folder, out=tmp_path_factory.mktemp("out") / "batch")


@pytest.mark.slow
def test_every_recording_of_a_folder_is_a_row(found, folder):
    table = found.table.set_index("test")
    assert list(table.index) == ["broken", *(f"rider_{name}" for name in NAMES)]
    assert list(table["status"]) == ["failed", "done", "done"]
    assert re.search(r"broken\.csv.*line 2", table["reason"]["broken"])
    for name in NAMES:
        alone = mf.identify(folder / f"rider_{name}.csv")
        assert table["arm_stiffness"][f"rider_{name}"] == alone.parameters["arm_stiffness"]["value"]


@pytest.mark.slow
def test_a_batch_goes_on_and_refuses_other_files(found, folder, tmp_path):
    before = (found.folder / "runs.parquet").read_bytes()
    mf.batch("identify", folder, out=found.folder)
    assert (found.folder / "runs.parquet").read_bytes() == before
    copied = shutil.copytree(folder, tmp_path / "copied")
    (copied / "broken.csv").unlink()
    with pytest.raises(InputError, match="holds another study"):
        mf.batch("identify", copied, out=found.folder)


@pytest.mark.slow
def test_a_manifest_has_a_row_for_each_test(tmp_path, capsys):
    for kind, seed in (("fit", 1), ("check", 8)):
        write_recording(joint_run({"friction": 0.3}, seed=seed, duration=5.0, name=kind), tmp_path / f"{kind}.csv")
    manifest = tmp_path / "tests.csv"
    manifest.write_text("test,recordings,validation,component\n"
                        "joint,fit.csv,check.csv,driven_joint\ngone,missing.csv,,driven_joint\n")  # fmt: skip
    assert main(["gap", "--batch", str(manifest), "--out", str(tmp_path / "out")]) == 0
    assert "2 tests, 1 failed: 1 named" in capsys.readouterr().out
    rows = pd.read_parquet(tmp_path / "out" / "runs.parquet").set_index("test")
    assert rows["effects"]["joint"] == "coulomb_friction"
    assert "missing.csv" in rows["reason"]["gone"]
    assert (tmp_path / "out" / "tests" / "joint" / "report.html").exists()
    assert np.isnan(rows["before"]["gone"])


@pytest.mark.parametrize(("text", "message"), [
    ("test,recording\na,b.csv\n", "unknown column 'recording', did you mean 'recordings'"),
    ("test,validation\na,b.csv\n", "has no column recordings"),
    ("recordings,rate\nb.csv,fast\n", "line 2: rate = 'fast' is not a number"),
    ("test,recordings\na,\n", "line 2: no recordings"),
    ("test,recordings\na,b.csv\na,c.csv\n", "two tests of .* have the name 'a'"),
])  # fmt: skip
def test_a_manifest_that_cannot_be_used_is_refused(tmp_path, text, message):
    manifest = tmp_path / "tests.csv"
    manifest.write_text(text)
    with pytest.raises(InputError, match=message):
        mf.batch("gap", manifest, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()
