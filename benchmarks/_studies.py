"""A small study of modes, started in a process of its own or on a cluster, and the bytes that it leaves."""

import hashlib
import multiprocessing
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import motofmi as mf
from fmus.support.errors import InputError

STARTED = 120.0  # s within which a cluster has to be there

# Six chunks of 0.5 s of processor time.
STUDY = """
kind = "modes"
device = ["none", "damper:7.5"]
speed = "20:60:1"
count = 300
seed = 3
[set]
rider = "~riders_2011"
"""


def contents(folder: Path) -> dict[str, str]:
    """The hash of every file by its path in the folder."""
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob("*")) if path.is_file()}  # fmt: skip


def chunks_complete(out: Path) -> int:
    """The number of chunks whose rows are written."""
    return len(list((out / "parts").glob("[0-9]*.parquet")))


def _in_own_session(study: Path, out: Path, scheduler: str | None) -> None:
    os.setsid()
    try:
        mf.sweep(study, out=out, scheduler=scheduler)
    except InputError as error:
        print(error, file=sys.stderr)
        os._exit(2)


def start(study: Path, out: Path, scheduler: str | None = None) -> Any:
    """The process of a study, which leads a session with its workers."""
    process = multiprocessing.get_context("fork").Process(target=_in_own_session, args=(study, out, scheduler))
    process.start()
    return process


@contextmanager
def cluster(folder: Path, workers: int = 2) -> Iterator[tuple[str, list[subprocess.Popen]]]:
    """The address of a Dask scheduler, and its process with those of its workers. Files lie in an existing folder."""
    import distributed  # noqa: PLC0415 - of the extra

    file, started = folder / "scheduler.json", []
    root = str(Path(__file__).parent.parent)
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": {**os.environ, "PYTHONPATH": root}}

    def run(*words: str) -> None:
        started.append(subprocess.Popen([sys.executable, "-m", "distributed.cli." + words[0], *words[1:]], **quiet))  # type: ignore[call-overload]

    try:
        run("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))
        for k in range(workers):
            run("dask_worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-nanny", "--no-dashboard",
                "--local-directory", str(folder / f"worker_{k}"))  # fmt: skip
        deadline = time.monotonic() + STARTED
        while not file.exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        with distributed.Client(scheduler_file=str(file), set_as_default=False) as client:
            client.wait_for_workers(workers, timeout=STARTED)
            address = client.scheduler.address
        yield address, started
    finally:
        for process in started:
            process.kill()
            process.wait()
