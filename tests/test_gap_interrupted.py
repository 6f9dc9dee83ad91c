"""A gap run that is ended from outside before its verdict leaves what it had, and no process."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from identification.recordings import write_recording

pytest.importorskip("numba", reason="the simulator of the hidden effects is compiled by numba")
import numpy as np
from simulators.as_recordings import as_recording
from simulators.hidden_rig import RIDER, record, sweep

PATIENCE = 60.0  # s
# A shell that runs tests in the background has them ignore interrupts, and their children with them.
COMMAND = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from scenarios.command_line import main; raise SystemExit(main())"


def until(condition):
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < PATIENCE
        time.sleep(0.02)


def left_by(file):
    return json.loads(file.read_text("utf-8"))


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="processes that start others")
@pytest.mark.parametrize("ended_by", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_it_leaves_what_it_had(tmp_path, ended_by):
    for name, excitation, seed in (("up", sweep(0.5, 12, 2, 60.0), 1), ("down", sweep(12, 0.5, 3, 60.0), 2)):
        # Two effects, so that pairs are tried after the first competition, which takes its time.
        arrays = record(excitation, {"ra": 0.1, "Tc": 0.5}, RIDER, np.random.default_rng(seed))
        write_recording(as_recording(name, arrays), tmp_path / f"{name}.csv")
    file = tmp_path / "out" / "verdict.json"
    process = subprocess.Popen([sys.executable, "-c", COMMAND, "gap", str(tmp_path / "up.csv"), str(tmp_path / "down.csv"), "--out", str(file.parent)],
                                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)  # fmt: skip
    try:
        until(lambda: file.exists() and (ended_by == signal.SIGTERM or left_by(file)["candidates"]))
    finally:
        process.send_signal(ended_by)
        assert process.wait(PATIENCE) != 0
    left = left_by(file)
    assert (left["verdict"], left["effects"], left["tied"], left["report"]) == ("unknown", [], [], None)
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
