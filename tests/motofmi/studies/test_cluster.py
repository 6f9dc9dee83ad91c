"""A study on a cluster of two separate worker processes, connected by TCP; one of them is killed in the middle."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import motofmi as mf
from fmus.support.errors import InputError
from tests import ROOT
from tests.motofmi.studies.test_study_store import STUDY, contents

distributed = pytest.importorskip("distributed", reason="the extra motofmi[scale] is not installed")
pytest.importorskip("zarr", reason="the extra motofmi[scale] is not installed")


@pytest.fixture
def cluster(tmp_path):
    """The address of a scheduler, and the processes of two workers."""
    file, started = tmp_path / "scheduler.json", []
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": {**os.environ, "PYTHONPATH": str(ROOT)}}

    def start(*words: str) -> subprocess.Popen:
        started.append(subprocess.Popen([sys.executable, "-m", "distributed.cli." + words[0], *words[1:]], **quiet))
        return started[-1]

    start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
    workers = [start("dask_worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-nanny", "--no-dashboard",
                     "--local-directory", str(tmp_path / f"worker_{k}")) for k in range(2)]  # fmt: skip
    deadline = time.monotonic() + 120
    while not file.exists() and time.monotonic() < deadline:
        time.sleep(0.1)
    with distributed.Client(scheduler_file=str(file), set_as_default=False) as client:
        client.wait_for_workers(2, timeout=120)
        address = client.scheduler.address
    yield address, workers
    for process in started:
        process.kill()
        process.wait()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::DeprecationWarning")
def test_a_cluster_that_loses_a_worker_gives_the_same_bytes(cluster, tmp_path):
    address, workers = cluster
    study, out = tmp_path / "study.toml", tmp_path / "cluster"
    study.write_text(STUDY.replace("count = 300", "count = 200"))
    described = mf.sweep(study, out=tmp_path / "local")
    killer = subprocess.Popen(
        [sys.executable, "-c", KILLER, str(out / "parts"), str(workers[0].pid), str(signal.SIGKILL.value)]
    )
    found = mf.sweep(study, out=out, scheduler=address)
    killer.wait()
    assert workers[0].wait(timeout=30) == -signal.SIGKILL  # the study did lose it
    assert found.runs == described.runs == 400 and found.failed == 0
    assert contents(out) == contents(tmp_path / "local")


# Waits for the first complete chunk, then ends a worker.
KILLER = """
import os, sys, time
folder, process, number = sys.argv[1:]
while not (os.path.isdir(folder) and any(name[0] != "." for name in os.listdir(folder))):
    time.sleep(0.01)
os.kill(int(process), int(number))
"""


def test_an_address_without_a_scheduler_is_named(tmp_path):
    with pytest.raises(InputError, match=r"no Dask scheduler at 127\.0\.0\.1:1 .*tcp://host:8786"):
        mf.sweep(speed=[30.0], out=tmp_path / "study", scheduler="127.0.0.1:1")
    assert not Path(tmp_path / "study" / "runs.parquet").exists()
