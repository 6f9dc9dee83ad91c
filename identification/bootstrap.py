"""Bootstrap of an identification: how far the parameters move when the measurement is made again.

With five or more runs, runs are drawn with replacement; with fewer, noise of each band's own variance is put
on the measured apparent inertia. The fits run on all cores.
"""

import os
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np

from fmus.progress import track
from identification.fit import Identification, identify
from identification.frf import FRF
from identification.response import Response

ENOUGH_RUNS = 5
CHUNK = 25  # fits that a process takes at once


def bootstrap(found: Identification, model: Response, count: int = 1000, seed: int = 0,
              bounds: Mapping[str, tuple[float, float]] | None = None, processes: int | None = None) -> np.ndarray:  # fmt: skip
    """Parameter vectors (count, np) from `count` repetitions, started at the best fit; the same for any number of processes."""
    model = Response(model.component.with_values(**dict(zip(found.names, found.values, strict=True))), model.input, model.output, found.names)
    processes = processes or cores()
    seeds = np.array_split(np.random.SeedSequence(seed).generate_state(count), -(-count // CHUNK))
    task = (found.frfs, model, found.method, bounds)
    return np.concatenate(list(track(_mapped(task, seeds, processes), "bootstrap", len(seeds))))


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _mapped(task: tuple, seeds: Sequence[np.ndarray], processes: int) -> Iterator[np.ndarray]:
    if processes == 1:
        _start(task)
        yield from map(_fits, seeds)
        return
    # A fork shares the compiled model; elsewhere each process derives its own once.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # forking beside the idle threads of BLAS
        with ProcessPoolExecutor(processes, get_context("fork" if sys.platform == "linux" else "spawn"), _start, (task,)) as pool:
            yield from pool.map(_fits, seeds)


_TASK: list[tuple] = []  # what this process repeats


def _start(task: tuple) -> None:
    _TASK[:] = [task]


def _fits(seeds: np.ndarray) -> np.ndarray:
    ((frfs, model, method, bounds),) = _TASK
    return np.array([identify(_again(frfs, np.random.default_rng(s)), model, method, bounds, starts=1).values for s in seeds])


def _again(frfs: Sequence[FRF], rng: np.random.Generator) -> list[FRF]:
    """The FRFs as another measurement would give them."""
    if len(frfs) >= ENOUGH_RUNS:
        return [frfs[i] for i in rng.integers(len(frfs), size=len(frfs))]

    def noisy(frf: FRF) -> FRF:
        error = np.sqrt(frf.variance / 2) * (rng.standard_normal(len(frf.variance)) + 1j * rng.standard_normal(len(frf.variance)))
        return replace(frf, inertance=1 / (frf.apparent_inertia + error))

    return [noisy(frf) for frf in frfs]
