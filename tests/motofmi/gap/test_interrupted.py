"""A gap run that is ended before its verdict leaves what it had, and no process."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from motofmi.cli.main import main
from motofmi.gap.selection import model_selection
from motofmi.recordings.reading import write_recording

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
import numpy as np

from tests import as_study
from tests.simulators.as_recordings import as_recording
from tests.simulators.hidden_bicycle import bicycle, ride, write_matrices, write_ride
from tests.simulators.hidden_rig import RIDER, record, sweep
from tests.simulators.hidden_vehicle import SHARP, spectrum, write

PATIENCE = 60.0  # s
# A shell that runs tests in the background has them ignore interrupts, and their children with them.
COMMAND = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from motofmi.cli.main import main; raise SystemExit(main())"


def until(condition):
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < PATIENCE
        time.sleep(0.02)


def left_by(file):
    return json.loads(file.read_text("utf-8"))


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "killpg"), reason="processes that start others")
@pytest.mark.parametrize(
    "ended_by, start_method", [as_study(signal.SIGINT, ""), (signal.SIGTERM, ""), as_study(signal.SIGKILL, ""), as_study(signal.SIGINT, "loky")]
)
def test_it_leaves_what_it_had(tmp_path, ended_by, start_method):
    for name, excitation, seed in (("up", sweep(0.5, 12, 2, 30.0), 1), ("down", sweep(12, 0.5, 3, 30.0), 2)):
        # Two effects, so that pairs are tried after the first competition, which takes its time.
        arrays = record(excitation, {"ra": 0.1, "Tc": 0.5}, RIDER, np.random.default_rng(seed))
        write_recording(as_recording(name, arrays), tmp_path / f"{name}.csv")
    file = tmp_path / "out" / "verdict.json"
    process = subprocess.Popen([sys.executable, "-c", COMMAND, "gap", str(tmp_path / "up.csv"), str(tmp_path / "down.csv"), "--out", str(file.parent)],
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True,
                                env={**os.environ, "MOTOFMI_START_METHOD": start_method, "OMP_NUM_THREADS": "2"})  # fmt: skip
    try:
        until(lambda: file.exists() and (ended_by == signal.SIGTERM or left_by(file)["candidates"]))
    finally:
        # A terminal interrupts the workers, too.
        (os.killpg if ended_by == signal.SIGINT else os.kill)(process.pid, ended_by)
        _, errors = process.communicate(timeout=PATIENCE)
        assert process.returncode != 0 and "Traceback" not in errors
    left = left_by(file)
    assert (left["verdict"], left["effects"], left["tied"]) == ("unknown", [], [])
    if ended_by == signal.SIGINT:
        assert left["report"] == "report.html" and (file.parent / "report.html").exists()
        assert errors.endswith(f"interrupted; written: {file}, {file.parent / 'report.html'}\n")
    else:
        assert left["report"] is None
    assert left["limitations"][0].startswith("Interrupted")
    assert left["base"]["device.arm_stiffness"]["value"] > 0 and left["where"]
    if ended_by != signal.SIGTERM:
        assert left["closest"]["name"] == left["candidates"][0]["name"] and left["gap"]["after"] < left["gap"]["before"]

    def gone():
        try:
            os.killpg(process.pid, 0)
        except ProcessLookupError:
            return True
        return False

    until(gone)


def eigenvalues(folder):
    speeds = np.arange(8.0, 57.0, 8.0)
    write(folder / "eigenvalues.csv", spectrum(SHARP, speeds, {}), speeds, np.random.default_rng(1), 0.01)
    return [str(folder / "eigenvalues.csv"), "--vehicle", "sharp_1971"]


def rides(folder):
    rng = np.random.default_rng(3)
    return [
        write_ride(folder / "run.csv", ride(rng, bicycle(rng, 0.03), friction=0.3)),
        "--vehicle",
        write_matrices(folder / "bicycle.toml"),
    ]


@pytest.mark.slow
@pytest.mark.parametrize("recorded", [eigenvalues, rides])
def test_vehicles_leave_what_is_known_of_their_base(tmp_path, monkeypatch, capsys, recorded):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(model_selection, "search_candidates", interrupted)
    assert main(["gap", *recorded(tmp_path), "--out", str(tmp_path / "out")]) == 130
    written = ", ".join(str(tmp_path / "out" / name) for name in ("verdict.json", "report.html"))
    assert capsys.readouterr().err == f"motofmi gap: interrupted; written: {written}\n"
    assert "Interrupted" in (tmp_path / "out" / "report.html").read_text("utf-8")
    left = left_by(tmp_path / "out" / "verdict.json")
    assert (left["verdict"], left["effects"], left["candidates"]) == ("unknown", [], [])
    assert left["limitations"][0].startswith("Interrupted") and left["gap"]["before"] > 0
