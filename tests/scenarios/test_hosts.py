"""The list of hosts: what each needs, where it is described, and that a new one is one file."""

import importlib.util
import subprocess
import sys

import pytest

from motofmi.scenarios.hosts import hosts, mujoco_bar, table
from motofmi.scenarios.hosts.rider_on_a_bar import ModeError
from tests import ROOT


def test_without_its_package_a_host_says_so_in_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)  # as if it were not installed
    with pytest.raises(SystemExit, match=r"mujoco is not installed: pip install '\.\[hosts\]'"):
        table.main(mujoco_bar.run)


def test_what_was_found_is_shown_by_name(capsys):
    table.main(lambda: {"loop": {"slow": ModeError(1.2, 0.24, -0.01, 0.1), "trajectory_error": 0.05}})
    assert [line.split() for line in capsys.readouterr().out.splitlines()] == [
        ["loop"], ["slow"], ["frequency", "1.2"], ["damping_ratio", "0.24"], ["frequency_error", "-0.01"], ["damping_error", "0.1"],
        ["trajectory_error", "0.05"]]  # fmt: skip


@pytest.mark.slow
def test_every_host_is_listed_and_says_what_it_needs():
    shown = subprocess.run(
        [sys.executable, "-m", "motofmi.scenarios.hosts"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    for name, host in hosts().items():
        assert host.HOST and host.__doc__ and callable(host.run)
        (line,) = [line for line in shown.splitlines() if f"motofmi.scenarios.hosts.{name}" in line.split()]
        assert line.startswith(host.HOST) and ("not installed" in line) == (
            importlib.util.find_spec(host.PACKAGE) is None
        )


SHARED = {"exudyn_corner_forces", "device", "exudyn_tree", "rider_on_a_bar", "table"}  # modules that hosts share


def test_the_page_of_hosts_names_every_module_that_runs_a_simulator():
    modules = {path.stem for path in (ROOT / "scenarios" / "hosts").glob("*.py") if not path.stem.startswith("_")}
    page = (ROOT / "docs" / "hosts.md").read_text("utf-8")
    assert set(hosts()) <= modules - SHARED
    assert [name for name in sorted(modules - SHARED) if f"`{name}`" not in page] == []


NEW = """
import numpy as np

HOST, PACKAGE = "a new tool", "numpy"


def run():
    return {"nothing": 0.0}


SAMPLES = {"a new tool": lambda fmus, step, count: np.zeros((count, 5))}
"""


@pytest.mark.slow
def test_a_host_is_one_file(tmp_path):
    """A new file in the folder of the hosts is in the list and in the benchmark of couplings."""
    (tmp_path / "new_tool.py").write_text(NEW, "utf-8")
    code = f"""
import motofmi.scenarios.hosts as package
package.__path__.append({str(tmp_path)!r})
from motofmi.scenarios.hosts.__main__ import main
main()
from benchmarks.coupling import PEERS
print("peers:", *PEERS, sep=";")
"""
    shown = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert any(
        line.split() == ["a", "new", "tool", "python", "-m", "motofmi.scenarios.hosts.new_tool"]
        for line in shown.splitlines()
    )
    peers = shown.rpartition("peers:")[2].strip().split(";")
    assert {"a new tool", "fmpy loop", "fmpy SSP runner", "fmucontainer in fmpy", "libcosim", "CoFMPy"} <= set(peers)
