"""A process with limits: it ends with all that it has started, and reaches no network."""

import os
import signal
import subprocess
import sys
import time

import psutil
import pytest

from fmus.support.sandbox import Limits, run_limited

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not hasattr(os, "fork"), reason="processes of POSIX")]
MB = 2**20


def python(code, **limits):
    return run_limited([sys.executable, "-c", code], Limits(**{"time": 30.0, **limits}), {"PYTHONPATH": os.pathsep.join(sys.path)})


def test_output_and_status():
    assert python("print('said'); raise SystemExit(3)").output.strip() == b"said"
    assert python("raise SystemExit(3)").status == 3
    assert python("import os; os.kill(os.getpid(), 11)").status == -11


def test_time_and_memory():
    began = time.monotonic()
    assert python("while True: pass", time=0.5).status is None
    outcome = python("import time; x = b'1' * 400_000_000; time.sleep(60)", memory=100 * MB)
    assert outcome.status is None and outcome.memory is not None and outcome.memory > 100 * MB
    assert time.monotonic() - began < 30


def test_a_large_output_does_not_block():
    assert len(python("print('x' * 3_000_000)").output) == 3_000_001


LEFT = """
import os, subprocess, sys, time
{how}
print("mark" + "{mark}")
"""
WAYS = {
    "session": "subprocess.Popen([sys.executable, '-c', 'import time; time.sleep(60)', '{mark}'], start_new_session=True)",
    "orphan": "\nif os.fork() == 0:\n    os.setsid()\n    if os.fork() == 0:\n        os.execv(sys.executable, [sys.executable, '-c', 'import time; time.sleep(60)', '{mark}'])\n    os._exit(0)\nos.wait()",
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_what_the_process_has_started_ends_with_it(way, tmp_path):
    """It also holds the output open, which must not cost the whole time."""
    mark, began = f"left-{way}-{os.getpid()}-{time.time_ns()}", time.monotonic()
    outcome = python(LEFT.format(how=WAYS[way].format(mark=mark), mark=mark), time=25.0)
    assert outcome.status == 0 and outcome.output.strip().endswith(mark.encode()) and time.monotonic() - began < 20
    assert not [p for p in psutil.process_iter(["cmdline"]) if mark in (p.info["cmdline"] or []) and p.status() != psutil.STATUS_ZOMBIE]


STARTER = """
import sys
from fmus.support.sandbox import Limits, run_limited
run_limited([sys.executable, "-c", {code!r}], Limits(time=60.0))
"""
BUSY = """
from fmus.support.sandbox import enter_sandbox
enter_sandbox()
import ctypes, os, pathlib
pathlib.Path({path!r} + "_").write_text(str(os.getpid()))
os.rename({path!r} + "_", {path!r})
ctypes.CDLL(None).sleep(60)
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL], ids=["terminated", "killed"])
def test_the_process_ends_with_the_one_that_started_it(number, tmp_path):
    path = tmp_path / "pid"
    code = STARTER.format(code=BUSY.format(path=str(path)))
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen([sys.executable, "-c", code], env=environment) as starter:
        until(path.exists)
        child = psutil.Process(int(path.read_text()))
        starter.send_signal(number)
    try:
        until(lambda: not child.is_running() or child.status() == psutil.STATUS_ZOMBIE)
    finally:
        if child.is_running():
            child.kill()


def until(condition, patience=15.0):
    began = time.monotonic()
    while not condition():
        assert time.monotonic() - began < patience
        time.sleep(0.05)


LIMITED = """
from fmus.support.sandbox import Limits, limit_resources
limit_resources(Limits(file_size=1_000_000))
open({path!r}, "wb").write(bytes(5_000_000))
"""


def test_a_file_cannot_grow_without_end(tmp_path):
    path = tmp_path / "large"
    assert python(LIMITED.format(path=str(path))).status == -25  # SIGXFSZ
    assert path.stat().st_size <= 1_000_000


NETWORK = """
from fmus.support.sandbox import leave_network
import socket
if not leave_network():
    print("not permitted")
else:
    print(sorted(name for _, name in socket.if_nameindex()))
    with socket.create_server(("127.0.0.1", 0)) as server, socket.create_connection(server.getsockname(), 5):
        print("loopback")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="network namespaces")
def test_there_is_no_network_but_a_loopback():
    said = python(NETWORK).output.decode().split("\n")
    if said[0] == "not permitted":
        pytest.skip("the system does not permit namespaces to users")
    assert said[:2] == ["['lo']", "loopback"]
