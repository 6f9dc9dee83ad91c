"""A study killed at any moment goes on and ends as if it had not been: the same bytes in every file."""

import hashlib
import multiprocessing
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

import motofmi as mf
from fmus.support.errors import InputError

pytest.importorskip("zarr", reason="the extra motofmi[scale] is not installed")
pytest.importorskip("pyarrow", reason="the extra motofmi[scale] is not installed")

# About ten chunks of 0.5 s of processor time.
STUDY = """
kind = "modes"
device = ["none", "damper:7.5"]
speed = "20:60:1"
count = 500
seed = 3
[set]
rider = "~riders_2011"
"""


def contents(folder: Path) -> dict[str, str]:
    """The hash of every file by its path in the folder."""
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob("*")) if path.is_file()}  # fmt: skip


def run_in_own_session(study: Path, out: Path) -> None:
    os.setsid()
    mf.sweep(study, out=out)


def start(study: Path, out: Path):
    process = multiprocessing.get_context("fork").Process(target=run_in_own_session, args=(study, out))
    process.start()
    return process


def parts(out: Path) -> int:
    return len(list((out / "parts").glob("[0-9]*.parquet")))


@pytest.mark.slow
def test_killed_at_random_moments_it_ends_with_the_same_bytes(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(STUDY)
    undisturbed = mf.sweep(study, out=tmp_path / "undisturbed")
    random = np.random.default_rng(0)
    killed = 0
    for _ in range(3):
        process = start(study, tmp_path / "killed")
        before = parts(tmp_path / "killed")
        while process.is_alive() and parts(tmp_path / "killed") <= before:
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
    assert undisturbed.runs == 1000


def test_another_study_is_refused(tmp_path):
    mf.sweep(speed=[30.0], out=tmp_path / "study", workers=1)
    with pytest.raises(InputError, match=r"holds another study \(axes.*|speed"):
        mf.sweep(speed=[31.0], out=tmp_path / "study", workers=1)
