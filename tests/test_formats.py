"""Recordings in the formats of other programs hold the same run as the CSV."""

import numpy as np
import pytest

from fmus.errors import InputError
from identification.recordings import read_recording
from tests.test_recordings import good


def assert_good(recording):
    np.testing.assert_allclose(recording["steer_torque"], good()["steer_torque"], atol=1e-9)
    np.testing.assert_allclose(recording.time, good().time, atol=1e-9)
    assert recording.units == {"steer_angle": "rad", "steer_torque": "N.m"}


def test_matlab(tmp_path):
    scipy_io = pytest.importorskip("scipy.io")
    units = {"time": "s", "steer_angle": "rad", "steer_torque": "N.m"}
    scipy_io.savemat(tmp_path / "run.mat", {"time": good().time, **good().columns, "units": units})
    assert_good(read_recording(tmp_path / "run.mat"))
    (tmp_path / "bad.mat").write_text("no MATLAB file")
    with pytest.raises(InputError, match=r"bad\.mat"):
        read_recording(tmp_path / "bad.mat")


def test_parquet(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    table = pyarrow.table({"time [s]": good().time, "steer_angle [rad]": good()["steer_angle"], "steer_torque [N.m]": good()["steer_torque"]})
    parquet.write_table(table, tmp_path / "run.parquet")
    assert_good(read_recording(tmp_path / "run.parquet"))


def test_universal_file(tmp_path):
    pyuff = pytest.importorskip("pyuff")
    for name, values in good().columns.items():
        data = {"type": 58, "func_type": 1, "id1": name, "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1, "binary": 0, "orddenom_spec_data_type": 0,
                "ordinate_axis_units_lab": good().units[name], "x": good().time, "data": values}  # fmt: skip
        pyuff.UFF(str(tmp_path / "run.uff")).write_sets(data, mode="add")
    recording = read_recording(tmp_path / "run.uff")
    # single precision in the file
    np.testing.assert_allclose(recording["steer_torque"], good()["steer_torque"], rtol=1e-5, atol=1e-5)


def test_mdf4(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(values, good().time, unit=good().units[name], name=name) for name, values in good().columns.items()])
        file.save(tmp_path / "run.mf4")
    assert_good(read_recording(tmp_path / "run.mf4"))
