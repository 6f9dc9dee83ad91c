"""A study on a cluster of two separate worker processes, connected by TCP; one of them is killed in the middle."""

import signal
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

import motofmi as mf
from benchmarks._studies import STUDY, cluster, contents
from fmus.support.errors import InputError

pytest.importorskip("distributed", reason="the extra motofmi[scale] is not installed")
pytest.importorskip("zarr", reason="the extra motofmi[scale] is not installed")


@pytest.fixture
def running(tmp_path):
    """The address of a scheduler, and the processes of two workers."""
    with cluster(tmp_path) as (address, (_, *workers)):
        yield address, workers


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::DeprecationWarning")
def test_a_cluster_that_loses_a_worker_gives_the_same_bytes(running, tmp_path):
    address, workers = running
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


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::DeprecationWarning")
def test_fmus_come_with_the_study_so_that_workers_need_no_compiler(tmp_path, monkeypatch):
    with ExitStack() as stack:
        with monkeypatch.context() as bare:  # the processes of the cluster inherit this: no compiler is found
            bare.delenv("CC", raising=False)
            bare.setenv("PATH", str(tmp_path / "empty"))
            bare.setenv("MOTOFMI_CACHE", str(tmp_path / "cache"))
            address, _ = stack.enter_context(cluster(tmp_path, workers=1))
        found = mf.sweep(kind="cosimulation", device=["damper:1"], speed=[30.0], duration=0.1, out=tmp_path / "out",
                         scheduler=address)  # fmt: skip
    assert (found.runs, found.failed) == (1, 0)
    assert not list(tmp_path.glob("cache/*.fmu"))  # the worker built none


def test_an_address_without_a_scheduler_is_named(tmp_path):
    with pytest.raises(InputError, match=r"no Dask scheduler at 127\.0\.0\.1:1 .*tcp://host:8786"):
        mf.sweep(speed=[30.0], out=tmp_path / "study", scheduler="127.0.0.1:1")
    assert not Path(tmp_path / "study" / "runs.parquet").exists()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::DeprecationWarning")
def test_a_lost_scheduler_is_named_and_the_study_goes_on(tmp_path):
    study, out = tmp_path / "study.toml", tmp_path / "out"
    study.write_text(STUDY)
    with cluster(tmp_path) as (address, processes):
        killer = subprocess.Popen(
            [sys.executable, "-c", KILLER, str(out / "parts"), str(processes[0].pid), str(signal.SIGKILL.value)]
        )
        with pytest.raises(InputError, match="the scheduler was lost; what is complete is kept"):
            mf.sweep(study, out=out, scheduler=address)
        killer.wait()
    mf.sweep(study, out=out)
    mf.sweep(study, out=tmp_path / "undisturbed")
    assert contents(out) == contents(tmp_path / "undisturbed")
