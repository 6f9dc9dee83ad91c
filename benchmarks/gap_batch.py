"""A batch of 200 simulated recordings through `motofmi gap`, ten broken files among them, killed in the middle.

    python -m benchmarks gap_batch

Every recording is 4 s of a driven joint whose angle is imposed, q(t) = sum of four sines; the torque that is measured
is

    J q'' + c q' + k q + F tanh(q' / v_s) + noise,

with dry friction F in every fifth recording, in which it is hidden from the model. The broken files are broken in ten
ways. The process and its workers are killed with kill -9 when a quarter of the tests is complete, and the batch is
started again. verdicts counts the answers by what was hidden, reasons has the reason of every file that could not be
used, computed_again the number of tests that were complete and were run a second time.
"""

import gzip
import os
import resource
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

import motofmi as mf
from motofmi.recordings.reading import write_recording
from motofmi.recordings.recording import Recording

FILES, BROKEN = 200, 10
INERTIA, DAMPING, STIFFNESS, FRICTION = 0.08, 0.12, 14.0, 0.3  # kg.m2, N.m.s/rad, N.m/rad, N.m
SLIDING, NOISE, SWING = 1e-3, 0.01, 0.25  # rad/s; N.m; rad/s of each sine
FREQUENCIES = np.array([0.5, 1.25, 2.0, 3.25])  # Hz
SECONDS, RATE, SEED = 4.0, 100.0, 100
EVERY = 5  # of so many recordings one hides friction
HEADER = "time [s],torque [N.m],angle [rad]\n"


def rows(count: int, text: Callable[[int], str] = lambda k: f"{0.01 * k:.2f},{k % 7},{0.01 * (k % 5)}\n") -> str:
    """So many rows of a recording."""
    return "".join(map(text, range(count)))


# Ways in which files of labs are broken, and their contents.
WAYS: dict[str, str | bytes] = {
    "cut_off": HEADER + rows(50) + "0.50,1.",
    "empty": "",
    "header_alone": HEADER,
    "no_angle": "time [s],torque [N.m]\n" + rows(200, lambda k: f"{0.01 * k:.2f},{k % 7}\n"),
    "no_time": "torque [N.m],angle [rad]\n" + rows(200, lambda k: f"{k % 7},{0.01 * (k % 5)}\n"),
    "unknown_unit": HEADER.replace("N.m", "furlong") + rows(200),
    "text_in_numbers": HEADER + rows(100) + "1.00,off,0.1\n" + rows(50),
    "time_goes_back": HEADER + rows(100) + rows(100),
    "no_numbers": HEADER + rows(200, lambda k: f"{0.01 * k:.2f},nan,nan\n"),
    "binary": gzip.compress(rows(300).encode(), mtime=0),
}


def imposed(name: str, friction: float, seed: int) -> Recording:
    """A recording of the joint with an imposed angle."""
    rng, time = np.random.default_rng(seed), np.arange(0, SECONDS, 1 / RATE)
    omega = 2 * np.pi * FREQUENCIES
    phase = np.outer(time, omega) + rng.uniform(0, 2 * np.pi, len(omega))
    angle, rate = np.sin(phase) @ (SWING / omega), np.cos(phase) @ np.full(len(omega), SWING)
    torque = INERTIA * (-np.sin(phase) @ (SWING * omega)) + DAMPING * rate + STIFFNESS * angle
    torque += friction * np.tanh(rate / SLIDING) + NOISE * rng.standard_normal(len(time))
    return Recording(name, time, {"torque": torque, "angle": angle}, {"torque": "N.m", "angle": "rad"})


def write_files(folder: Path, files: int, broken: int) -> None:
    """The recordings and the broken files."""
    for k in range(files - broken):
        name, friction = (f"friction_{k:03d}", FRICTION) if k % EVERY == 1 else (f"nothing_{k:03d}", 0.0)
        write_recording(imposed(name, friction, SEED + k), folder / f"{name}.csv")
    for name, contents in list(WAYS.items())[:broken]:
        (folder / f"broken_{name}.csv").write_bytes(contents if isinstance(contents, bytes) else contents.encode())


def run_batch(recordings: Path, out: Path) -> Any:
    """The batch, from the beginning or from where it ended."""
    return mf.batch("gap", recordings, component="driven_joint", impose="angle", out=out)


def killed(recordings: Path, out: Path, complete: int) -> dict[str, int]:
    """Start the batch in a session of its own, and kill that when so many tests are complete: the times of their
    files."""

    def alone() -> None:
        os.setsid()
        run_batch(recordings, out)

    process = get_context("fork").Process(target=alone)
    process.start()
    while process.is_alive() and len(list((out / "parts").glob("[0-9]*.parquet"))) < complete:
        time.sleep(0.1)
    if process.is_alive() and process.pid:
        os.killpg(process.pid, signal.SIGKILL)
    process.join()
    return written(out)


def written(out: Path) -> dict[str, int]:
    """When the verdict of each complete test was written [ns], by test."""
    return {path.parent.name: path.stat().st_mtime_ns for path in (out / "tests").glob("*/verdict.json")}


def run(progress: Callable[..., Iterable], files: int = FILES, broken: int = BROKEN) -> dict[str, Any]:
    """Verdicts, reasons, what was computed a second time, and the processor time [s] of all processes."""
    began = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as folder:
        recordings, out = Path(folder) / "recordings", Path(folder) / "batch"
        recordings.mkdir()
        write_files(recordings, files, broken)
        before = killed(recordings, out, files // 4)
        complete = {path.stem for path in (out / "parts").glob("[0-9]*.parquet")}
        found = run_batch(recordings, out)
        now, table = written(out), found.table
        reasons = {n: r.replace(f"{recordings}/", "") for n, r in found.to_dict()["reasons"].items()}
    done = table[table["status"] == "done"]
    finished = {row["test"] for _, row in table.iterrows() if f"{row['run']:08d}" in complete}
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    said = Counter((row["test"].partition("_")[0], row["effects"] or row["verdict"]) for _, row in done.iterrows())
    return {
        "files": files,
        "broken": broken,
        "verdicts": len(done),
        "by_hidden": {f"{hidden} -> {answer}": count for (hidden, answer), count in sorted(said.items())},
        "reasons": reasons,
        "complete_when_killed": len(finished),
        "computed_again": sum(now[name] != before[name] for name in finished if name in before),
        "cpu_seconds": sum(getattr(ended, n) - getattr(began, n) for n in ("ru_utime", "ru_stime")),
    }
