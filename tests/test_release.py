"""What a release carries: ready-made archives that are used where no compiler is, and a wheel that has them."""

import subprocess
import sys
import zipfile
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import pytest
from importer import Opened

from fmus import ready_made
from fmus.build import build
from fmus.compilers import host_compiler
from fmus.errors import MissingToolError
from rider_fmu import riders

HERE = Path(__file__).parent.parent
pytestmark = pytest.mark.skipif(host_compiler() is None, reason="no C compiler on this machine")


@pytest.fixture
def ready(tmp_path, monkeypatch):
    """A folder of ready-made archives, and then a machine without a compiler."""
    folder = tmp_path / "built"
    build(riders.load("mean_2011"), folder)
    monkeypatch.setattr(ready_made, "FOLDER", folder)
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr("fmus.compilers.find_spec", lambda name: None)
    return folder


def test_a_ready_made_archive_needs_no_compiler(ready, tmp_path):
    built = build(riders.load("mean_2011"), tmp_path / "out")
    assert built.path.read_bytes() == (ready / built.path.name).read_bytes()
    fmu = Opened(built.path).start(torso_angle=0.1)
    fmu.fmu.doStep(0.0, 0.01)
    fmu.close()


def test_one_that_does_not_fit_is_not_used(ready, tmp_path):
    with pytest.raises(MissingToolError):
        build(riders.load("mean_2011", arm_damping=20.0), tmp_path / "out")
    with pytest.raises(MissingToolError):
        build(riders.load("mean_2011"), tmp_path / "out", fmi=3)


@pytest.mark.skipif(find_spec("build") is None or int(version("setuptools").split(".")[0]) < 77,
                    reason="build, or setuptools from 77 on, is not installed (pip install motofmi[dev])")  # fmt: skip
def test_the_wheel_carries_code_values_and_ready_made_archives(tmp_path):
    listed = subprocess.run(["git", "ls-files"], cwd=HERE, capture_output=True, text=True, check=False).stdout.split("\n")
    if "pyproject.toml" not in listed:
        pytest.skip("not in a checkout")
    for name in filter(None, listed):
        if (HERE / name).is_file():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_bytes((HERE / name).read_bytes())
    built = build(riders.load("mean_2011"), tmp_path / "fmus" / "built")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--skip-dependency-check"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (wheel,) = (tmp_path / "dist").glob("*.whl")
    with zipfile.ZipFile(wheel) as members:
        names = set(members.namelist())
        assert members.read(f"fmus/built/{built.path.name}") == built.path.read_bytes()
    assert {"fmus/runtime/step.c", "fmus/runtime/model.c.in", "fmus/runtime/LICENSE.txt", "fmus/python_slave.py.in",
            "rider_fmu/riders/mean_2011.toml", "vehicle_fmu/motorcycles/sharp_1971.toml"} <= names  # fmt: skip
