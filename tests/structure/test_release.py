"""The contents of a release: prebuilt archives, used where no compiler is installed, and a wheel that contains them."""

import json
import os
import subprocess
import sys
import tomllib
import zipfile
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import pytest

from fmus.export import prebuilt
from fmus.export.build import build
from fmus.export.compilers import host_compiler
from fmus.support.errors import MissingToolError
from rider_fmu import riders
from tests import ROOT
from tests.importer import Opened
from tests.installation import NAMES, built_wheel, copied_checkout, environment_with, listed_files

pytestmark = pytest.mark.skipif(host_compiler() is None, reason="no C compiler on this machine")


@pytest.fixture
def archives(tmp_path, monkeypatch, request):
    """A folder of prebuilt archives, and then a machine without a compiler."""
    folder = tmp_path / "built"
    build(riders.load("mean_2011"), folder)
    monkeypatch.setattr(prebuilt, "FOLDER", folder)
    request.getfixturevalue("without_compiler")
    return folder


@pytest.mark.slow
def test_a_prebuilt_archive_needs_no_compiler(archives, tmp_path):
    built = build(riders.load("mean_2011"), tmp_path / "out")
    assert built.path.read_bytes() == (archives / built.path.name).read_bytes()
    fmu = Opened(built.path).start(torso_angle=0.1)
    fmu.fmu.doStep(0.0, 0.01)
    fmu.close()


@pytest.mark.slow
def test_one_that_does_not_fit_is_not_used(archives, tmp_path):
    with pytest.raises(MissingToolError):
        build(riders.load("mean_2011", arm_damping=20.0), tmp_path / "out")
    with pytest.raises(MissingToolError):
        build(riders.load("mean_2011"), tmp_path / "out", fmi=3)


needs_build = pytest.mark.skipif(find_spec("build") is None or int(version("setuptools").split(".")[0]) < 77,
                                 reason="build, or setuptools from 77 on, is not installed (pip install motofmi[dev])")  # fmt: skip
# Run beside folders of a lab that are called like folders of the project.
SCRIPT = """
import json, sys
from importlib.util import find_spec
from pathlib import Path
import identification, scenarios
assert (identification.OWN, scenarios.OWN) == (1, 2)
import motofmi
from motofmi.reports.glossary import terms
from motofmi.workflows.scenarios import scenario, scenario_names
assert "weave" in terms()
assert scenario("is_a_rider_a_damper").run is not None
print(json.dumps({"version": motofmi.__version__, "scenarios": scenario_names(), "where": motofmi.__file__,
                  "found": [name for name in sys.argv[1:] if find_spec(name)], "rider": motofmi.rider("mean_2011").name}))
"""


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """A copy of what git lists, with one prebuilt archive."""
    if "pyproject.toml" not in listed_files():
        pytest.skip("not in a checkout")
    folder = copied_checkout(tmp_path_factory.mktemp("checkout"))
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("MOTOFMI_CACHE", str(tmp_path_factory.mktemp("archives")))
        build(riders.load("mean_2011"), folder / "fmus" / "built")
    return folder


@pytest.fixture(scope="module")
def wheel(checkout):
    return built_wheel(checkout)


@pytest.mark.slow
@needs_build
def test_the_wheel_contains_code_values_and_prebuilt_archives(checkout, wheel):
    (built,) = (checkout / "fmus" / "built").glob("*.fmu")
    with zipfile.ZipFile(wheel) as members:
        names = set(members.namelist())
        assert members.read(f"fmus/built/{built.name}") == built.read_bytes()
    assert {"fmus/export/runtime/step.c", "fmus/export/runtime/model.c.in", "fmus/export/runtime/LICENSE.txt", "fmus/export/python_slave.py.in",
            "rider_fmu/riders/mean_2011.toml", "vehicle_fmu/motorcycles/sharp_1971.toml", "motofmi/py.typed",
            "motofmi/docs/glossary.md", "motofmi/schemas/verdict.json", "motofmi/reports/explore/modules/PassiveRider.json",
            "motofmi/reports/page/report.html", "motofmi/reports/page/charts.js",
            *(f"motofmi/reports/page/vendor/{name}" for name in ("echarts.min.js", "LICENSE.txt", "NOTICE.txt", "LICENSE-zrender.txt"))} <= names  # fmt: skip
    assert {name.partition("/")[0] for name in names if ".dist-info/" not in name} == NAMES
    assert {name for name in names if name.startswith("motofmi/docs/")} == {"motofmi/docs/glossary.md"}
    assert "motofmi/scenarios/__init__.py" in names and "motofmi/scenarios.py" not in names


@pytest.fixture(scope="module", params=["wheel", "editable", "checkout"])
def installed(request, checkout, tmp_path_factory):
    """A Python in which the project is installed as a wheel, installed from the folder, or not installed but on the
    path; and how it runs."""
    if request.param == "checkout":
        return [sys.executable], {"PYTHONPATH": str(checkout)}, checkout
    if find_spec("build") is None or int(version("setuptools").split(".")[0]) < 77:
        pytest.skip("build, or setuptools from 77 on, is not installed (pip install motofmi[dev])")
    folder = tmp_path_factory.mktemp(request.param)
    what = (
        [str(request.getfixturevalue("wheel"))]
        if request.param == "wheel"
        else ["--no-build-isolation", "-e", str(checkout)]
    )
    return [str(environment_with(folder, *what))], {}, folder if request.param == "wheel" else checkout


def _run(command, environment, folder):
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, cwd=folder, env={**kept, **environment}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_folders_of_a_lab_do_no_harm_and_suffer_none(installed, tmp_path):
    python, environment, where = installed
    for name, own in (("identification", 1), ("scenarios", 2)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text(f"OWN = {own}\n", "utf-8")
    (tmp_path / "script.py").write_text(SCRIPT, "utf-8")
    found = json.loads(_run([*python, "script.py", *NAMES], environment, tmp_path))
    assert Path(found["where"]).is_relative_to(where)
    assert found["version"] == tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    assert set(found["found"]) == NAMES and found["rider"] == "rider_mean_2011"
    assert set(found["scenarios"]) == {path.stem for path in (ROOT / "scenarios").glob("*.py")} - {"__init__"}


@pytest.mark.slow
def test_the_command_and_the_module_run(installed, tmp_path):
    python, environment, _ = installed
    expected = f"motofmi {tomllib.loads((ROOT / 'pyproject.toml').read_text('utf-8'))['project']['version']}"
    assert _run([*python, "-m", "motofmi", "--version"], environment, tmp_path).strip() == expected
    if not environment:  # installed: there is a command, and nothing but the four names
        assert _run([str(Path(python[0]).with_name("motofmi")), "--version"], environment, tmp_path).strip() == expected
        code = "from importlib.util import find_spec; print([n for n in ('scenarios', 'identification', 'tests', 'benchmarks') if find_spec(n)])"
        assert _run([*python, "-c", code], environment, tmp_path).strip() == "[]"


@pytest.mark.slow
@needs_build
@pytest.mark.skipif(find_spec("twine") is None, reason="twine is not installed (pip install motofmi[dev])")
def test_an_index_accepts_the_wheel(wheel):
    done = subprocess.run([sys.executable, "-m", "twine", "check", "--strict", str(wheel)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
