"""What a verdict of the gap workflow costs: seconds, processor seconds and peak memory, over samples and size of the library.

Each case is a process of its own: recordings of two fitted runs and a held-out one are made by the simulator of the
tests, then prepared and decided on with the whole library. Times do not include that simulator. Preparing and screening
are the same work in every case, and show how the cost grows; how many fits follow depends on what there is to be found.
"""

import multiprocessing
import resource
import time
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np

from benchmarks._memory import peak_memory
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.screening import screen
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run
from motofmi.gap.selection.model_selection import select_model
from motofmi.gap.verdict import as_result
from motofmi.workflows.gap.rig import rig_effects, rig_experiment
from rider_fmu.rigs.handlebar import HANDLEBAR_INERTIA
from tests.simulators.as_recordings import as_recording
from tests.simulators.hidden_rig import RIDER, RUNS, record, sweep

RIG = {"handlebar_inertia": {"value": HANDLEBAR_INERTIA, "standard_error": 0.01 * HANDLEBAR_INERTIA}}
CASES: dict[str, dict[str, float]] = {
    "none": {},
    "friction": {"Tc": 0.5},
    "reflex": {"kr": 18.0, "tau": 0.09},
    "two": {"Tc": 0.7, "g": 0.0023},
}
DURATIONS = (200.0, 400.0, 800.0)
HOUR = 1200.0  # s of each of three runs
SHARES = (0.25, 0.5, 1.0)  # of the library


def run(progress, cases=tuple(CASES), durations=DURATIONS, shares=SHARES, hour: float = HOUR) -> dict:
    """Costs by case, by duration of the runs, by size of the library, and of an hour of data."""
    jobs = {
        **{f"case {name}": (name, 0.0, 1.0) for name in cases},
        **{f"{d:g} s": ("none", d, 1.0) for d in durations},
        **{f"{share:.0%} of the library": ("none", 0.0, share) for share in shares},
        f"{3 * hour:g} s in all": ("none", hour, 1.0),
    }
    results = {}
    for name, job in progress(list(jobs.items()), "verdicts"):
        with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
            results[name] = pool.submit(measured, *job).result()
    return results


def measured(case: str, duration: float, share: float) -> dict[str, Any]:
    """Cost of one verdict: on the usual runs, or on sweeps of a duration [s], with a share of the library."""
    excitations = list(RUNS.values())
    if duration:
        excitations = [sweep(0.5, 12, 2, duration), sweep(0.5, 12, 4, duration), sweep(12, 0.5, 3, duration)]
    rng = np.random.default_rng(1)
    recordings = [as_recording(f"run_{i}", record(e, CASES[case], RIDER, rng)) for i, e in enumerate(excitations)]
    library = rig_effects()
    library = library[: max(round(share * len(library)), 1)]
    wall, start = time.perf_counter(), _processor_time()
    runs = [prepare_steer_test_run(r, "steer_angle", "steer_torque", "steer_angle_command") for r in recordings]
    model = HarmonicModel(rig_experiment(RIG))
    prepared = _processor_time()
    result = as_result(select_model(model, runs[:2], library, runs[2:]), "N.m")
    wall, decided = time.perf_counter() - wall, _processor_time()
    base = fit(model, runs[:2], model.start())
    fitted = _processor_time()
    screen(base, library)
    return {"verdict": result["verdict"], "effects": [e["name"] for e in result["effects"]], "samples": sum(len(r.time) for r in recordings),
            "library": len(library), "wall_s": wall, "cpu_s": decided - start, "preparing_cpu_s": prepared - start,
            "screening_cpu_s": _processor_time() - fitted, "peak_mb": peak_memory()}  # fmt: skip


def _processor_time() -> float:
    """Of this process and those that it has forked and awaited [s]."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in used)
