"""A study that is killed (kill -9) at random moments, and resumed after each: lost chunks, and the bytes at the end.

Of twenty kills every second ends the client with its workers, every second one worker; a last run is on a cluster whose
scheduler is killed. A chunk is lost where it was complete before a kill and is not complete after it.
"""

import os
import signal
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import psutil

import motofmi as mf
from benchmarks._studies import STUDY, chunks_complete, cluster, contents, start

LONGEST = 2.0  # s after the first new chunk, at most
KILLS = 20


def killed(study: Path, out: Path, client: bool, wait: float) -> dict[str, int]:
    """Start or resume a study and kill a process of it: how many chunks it had before and after, and whether it ran."""
    process, before = start(study, out), chunks_complete(out)
    while process.is_alive() and chunks_complete(out) <= before:
        time.sleep(0.01)
    time.sleep(wait)
    complete = chunks_complete(out)
    workers = psutil.Process(process.pid).children(recursive=True) if process.is_alive() else []
    hit = bool(workers)
    if client and hit:
        os.killpg(process.pid, signal.SIGKILL)
    elif hit:
        workers[-1].kill()
        time.sleep(0.2)
        os.killpg(process.pid, signal.SIGKILL)  # so that the next kill meets a study that is not complete
    process.join()
    return {"hit": hit, "lost": max(complete - chunks_complete(out), 0)}


def without_scheduler(study: Path, out: Path, folder: Path) -> bool:
    """Whether a study ends with an error, and not silently, once the scheduler of its cluster was killed."""
    with cluster(folder) as (address, processes):
        process = start(study, out, address)
        while process.is_alive() and chunks_complete(out) < 1:
            time.sleep(0.01)
        processes[0].kill()
        process.join(300)
        ended = process.exitcode
        if process.is_alive():
            process.kill()
            process.join()
    return ended not in (0, None)


def run(progress: Callable[..., Any], kills: int = KILLS, members: int = 3000) -> dict[str, Any]:
    """Kills that met a running study, complete chunks that were lost, and whether the bytes are those of a study that
    ran undisturbed."""
    random, counts = np.random.default_rng(0), []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        study = folder / "study.toml"
        study.write_text(STUDY.replace("count = 300", f"count = {members}"))
        mf.sweep(study, out=folder / "undisturbed")
        expected = contents(folder / "undisturbed")
        for k in progress(range(kills), "kills"):
            counts.append(killed(study, folder / "killed", k % 2 == 0, random.uniform(0.0, LONGEST)))
        mf.sweep(study, out=folder / "killed")
        equal = contents(folder / "killed") == expected
        ended = without_scheduler(study, folder / "scheduler", folder)
        mf.sweep(study, out=folder / "scheduler")
        resumed = contents(folder / "scheduler") == expected
    return {"kills": sum(c["hit"] for c in counts), "complete_chunks_lost": sum(c["lost"] for c in counts),
            "bytes_equal": equal, "scheduler_killed_is_an_error": ended, "bytes_equal_after_scheduler": resumed}  # fmt: skip
