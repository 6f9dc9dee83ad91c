"""A study killed at any moment goes on and ends as if it had not been: the same bytes in every file."""

import multiprocessing
import os
import re
import resource
import signal
import time
from pathlib import Path

import numpy as np
import psutil
import pytest

import motofmi as mf
from benchmarks._studies import STUDY, chunks_complete, contents, start
from fmus.support.errors import InputError

pytest.importorskip("zarr", reason="the extra motofmi[scale] is not installed")
pytest.importorskip("pyarrow", reason="the extra motofmi[scale] is not installed")

@pytest.mark.slow
def test_killed_at_random_moments_it_ends_with_the_same_bytes(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(STUDY)
    undisturbed = mf.sweep(study, out=tmp_path / "undisturbed")
    random = np.random.default_rng(0)
    killed = 0
    for _ in range(3):
        process = start(study, tmp_path / "killed")
        before = chunks_complete(tmp_path / "killed")
        while process.is_alive() and chunks_complete(tmp_path / "killed") <= before:
            time.sleep(0.02)
        time.sleep(random.uniform(0.0, 0.3))
        if process.is_alive():
            os.killpg(process.pid, signal.SIGKILL)  # the client and its workers at once
            killed += 1
        process.join()
    assert killed, "the study ended before it could be killed"
    found = mf.sweep(study, out=tmp_path / "killed")
    assert found.failed == 0
    assert contents(tmp_path / "killed") == contents(tmp_path / "undisturbed")
    assert undisturbed.runs == 600


def worker_of(process) -> int:
    """The process id of a worker of the study's client."""
    while process.is_alive():
        children = psutil.Process(process.pid).children()
        if children:
            return children[-1].pid
        time.sleep(0.02)
    raise AssertionError("the study ended before it had a worker")


@pytest.mark.slow
def test_a_killed_worker_costs_nothing_but_its_chunks(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(STUDY.replace("300", "100"))
    process = start(study, tmp_path / "killed")
    os.kill(worker_of(process), signal.SIGKILL)
    process.join()
    assert process.exitcode == 0
    mf.sweep(study, out=tmp_path / "undisturbed")
    assert contents(tmp_path / "killed") == contents(tmp_path / "undisturbed")


def fill_up(study: Path, out: Path, limit: int) -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    try:
        mf.sweep(study, out=out, workers=1)
    except InputError as error:
        (out / "error.txt").write_text(str(error)[:limit])
        os._exit(2)


@pytest.mark.slow
def test_a_full_disk_is_named_and_nothing_is_silently_wrong(tmp_path):
    """Files longer than 100 kB cannot be written, as on a full disk: the first chunk of eigenvalues is one of them."""
    study = tmp_path / "study.toml"
    study.write_text(STUDY.replace("300", "100"))
    process = multiprocessing.get_context("fork").Process(target=fill_up, args=(study, tmp_path / "full", 100_000))
    process.start()
    process.join()
    error = tmp_path / "full" / "error.txt"
    assert process.exitcode == 2
    assert re.search("cannot write .*File too large; what is complete is kept: free space", error.read_text())
    error.unlink()
    with pytest.raises(InputError, match="is not complete: start it again"):
        mf.open_study(tmp_path / "full")
    mf.sweep(study, out=tmp_path / "full")
    mf.sweep(study, out=tmp_path / "undisturbed")
    assert contents(tmp_path / "full") == contents(tmp_path / "undisturbed")


@pytest.mark.slow
@pytest.mark.parametrize("damage", [Path.unlink, lambda path: path.write_bytes(path.read_bytes()[:-9] + b"123456789")])
def test_a_missing_or_damaged_chunk_is_found_and_computed_again(tmp_path, damage):
    found = mf.sweep(device=["none", "damper:2", "damper:4"], speed=[30.0, 40.0], out=tmp_path / "study", workers=1)
    before = contents(found.folder)
    chunk = next(path for path in (found.folder / "results.zarr" / "eigenvalue" / "c").rglob("*") if path.is_file())
    damage(chunk)
    with pytest.raises((InputError, ValueError, RuntimeError)):  # of the checksum where the file is there
        mf.open_study(found.folder).dataset["eigenvalue"].load()
    mf.sweep(device=["none", "damper:2", "damper:4"], speed=[30.0, 40.0], out=tmp_path / "study", workers=1)
    assert contents(found.folder) == before


def test_another_study_is_refused(tmp_path):
    mf.sweep(speed=[30.0], out=tmp_path / "study", workers=1)
    with pytest.raises(InputError, match=r"holds another study \(axes.*|speed"):
        mf.sweep(speed=[31.0], out=tmp_path / "study", workers=1)
