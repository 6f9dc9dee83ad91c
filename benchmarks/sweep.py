"""Studies: a million named spectra against bare stacked eigenvalue problems, co-simulations against a plain loop, the
engine's overhead, memory over the number of runs, and 1 to 8 workers.

Times are processor times of this process and its workers, so that they are the same on a busy machine; `two_cores_s` is
half of them. 1,000 riders of the 2011 population x 10 dampers x 100 speeds; 1,000 riders x 2 speeds co-simulated for
5 s in steps of 1 ms.
"""

import multiprocessing
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._memory import peak_memory
from fmus.cosimulation.cosimulate import cosimulate
from fmus.support.parallel import processes
from motofmi.workflows.sweep.cosimulation_runs import opened_run
from motofmi.workflows.sweep.study import Study
from motofmi.workflows.sweep.sweep import Prepared

SPEEDS = np.linspace(1.0, 60.0, 100)
DAMPERS = [f"damper:{value:g}" for value in np.linspace(0.0, 18.0, 10)]
SAMPLE = 20_000  # spectra of the bare eigenvalue problems


def modes_study(riders: int, dampers: int = 10) -> Study:
    """Named modes of so many riders with so many dampers at 100 speeds."""
    return Study(device=DAMPERS[:dampers], speed=SPEEDS, set={"rider": "~riders_2011"}, count=riders)


def run_study(riders: int, speeds: int = 2) -> Study:
    """Co-simulations of so many riders at two speeds."""
    return Study(kind="cosimulation", speed=np.linspace(20.0, 50.0, speeds), set={"rider": "~riders_2011"},
                 count=riders, options={"initial": {"steer_rate": 0.5}})  # fmt: skip


def processor_time() -> float:
    """Of this process and of its ended workers [s]."""
    return sum(
        used.ru_utime + used.ru_stime
        for used in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


def timed(action: Callable[[], Any]) -> float:
    """The processor time [s] of an action."""
    began = processor_time()
    action()
    return processor_time() - began


def stored(study: Study, workers: int | None = None) -> float:
    """The processor time [s] of a study with its store; what is compiled once is compiled before."""
    with tempfile.TemporaryDirectory() as folder:
        prepared = Prepared.of(study, Path(folder) / "study")
        prepared.runs.compute(prepared.runs.grid.indices(0)[:1])
        return timed(lambda: prepared.run(workers=workers))


def bare_eigenvalues(study: Study) -> float:
    """The processor time [s] of numpy.linalg.eig for a spectrum, on a stack of the study's matrices."""
    runs = study.runs()
    linearised = runs.systems.stacked(0, 0, np.zeros((1, 3), int))
    matrices = linearised(np.zeros(SAMPLE, int), np.linspace(1.0, 60.0, SAMPLE)).A
    return min(timed(lambda: np.linalg.eig(matrices)) for _ in range(3)) / SAMPLE


def direct(study: Study) -> float:
    """The processor time [s] of the runs of a study without engine and store."""
    runs = study.runs()
    runs.compute(runs.grid.indices(0)[:1])
    return timed(lambda: [runs.compute(runs.grid.indices(k)) for k in range(runs.grid.chunks)])


def plain_loop(study: Study) -> tuple[float, float]:
    """The processor times [s] for a run of opening its FMUs, and of the co-simulation alone."""
    runs = study.runs()
    opening = looping = 0.0
    for indices in (runs.grid.indices(k) for k in range(runs.grid.chunks)):
        for one in indices:
            began = time.process_time()
            with opened_run(runs, one) as opened:
                middle = time.process_time()
                cosimulate(opened.fmus, runs.options["step"][0], runs.options["duration"], wiring=opened.wiring)
                ended = time.process_time()
            opening, looping = opening + middle - began, looping + ended - middle
    return opening / runs.grid.runs, looping / runs.grid.runs


def study_memory(riders: int) -> float:
    """The largest resident memory [MB] of the client or a worker, in a process of its own."""
    receiver, sender = multiprocessing.Pipe(duplex=False)

    def child() -> None:
        stored(modes_study(riders, 2))
        sender.send(peak_memory())

    process = multiprocessing.get_context("fork").Process(target=child)
    process.start()
    process.join()
    return receiver.recv()


def run(progress: Callable[..., Any], riders: int = 1000, runs: int = 1000, small: int = 200) -> dict[str, Any]:
    """Processor times [s], ratios and memory [MB]."""
    found: dict[str, Any] = {}
    steps = iter(progress(range(6), "studies"))
    next(steps)
    study = modes_study(riders)
    bare, whole = bare_eigenvalues(study), stored(study)
    spectra = riders * 10 * len(SPEEDS)
    found |= {"spectra": spectra, "modes_s": whole, "two_cores_s": whole / 2, "eig_s": bare * spectra,
              "ratio": whole / (bare * spectra)}  # fmt: skip
    next(steps)
    opening, looping = plain_loop(run_study(min(runs, 50)))
    whole = stored(run_study(runs))
    found |= {"cosimulations": 2 * runs, "cosimulations_s": whole, "cosimulation_opening_s": opening,
              "cosimulation_bare_s": looping, "cosimulation_ratio": whole / (2 * runs * looping),
              "cosimulation_ratio_with_opening": whole / (2 * runs * (opening + looping))}  # fmt: skip
    next(steps)
    alone = min(direct(modes_study(small)) for _ in range(2))
    found["overhead"] = min(stored(modes_study(small), 1) for _ in range(2)) / alone - 1.0
    next(steps)
    found["memory_MB"] = {f"{2 * count} runs": study_memory(count) for count in (small, 8 * small)}
    next(steps)
    found["workers_s"] = {str(count): stored(modes_study(small), count) for count in (1, 2, 4, 8)}
    found["cores"] = processes()
    return found
