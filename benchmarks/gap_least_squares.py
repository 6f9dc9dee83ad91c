"""The gap workflow's least squares against scipy.optimize.least_squares: evaluations, time, chi-square and verdicts.

    python -m benchmarks.gap_least_squares [--rig 01 02 ...] [--mechanisms 1 2 ...] [--out FILE.json]

Whole searches on one processor, with the same problems, bounds and exact Jacobians. SciPy's methods trf and dogbox
scale by the Jacobian and end with the same criterion (a step that gains less than is asked for); the bound on a step
and the chi-square to be reached, which SciPy does not know, are left out. Seconds are processor time.
"""

import argparse
import json
import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from benchmarks import gap_generic
from fmus.support.errors import InputError
from fmus.support.progress import track
from motofmi.gap.estimation import fitting
from motofmi.gap.estimation.levenberg_marquardt import Problem, Solution, levenberg_marquardt
from motofmi.gap.experiments.input_output import input_output_experiment
from motofmi.gap.models.harmonic_model import HarmonicModel
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.preprocessing.steer_test_run import prepare_steer_test_run
from motofmi.gap.selection.any_component import investigate
from motofmi.gap.selection.model_selection import select_model
from motofmi.recordings.reading import read_recording
from motofmi.recordings.rig_file import read_rig
from motofmi.workflows.components import component
from motofmi.workflows.gap.rig import rig_effects, rig_experiment
from tests import SHARED_DATA
from tests.simulators.mechanism_cases import draw

RIGS = ("01", "02", "03", "05")
MECHANISMS = tuple(map(str, range(1, 13)))
RECORDED = {
    "mr_damper/10mm1Hz1A.csv": ("mass_spring_damper", "displacement"),
    "pendulum_camera/pendulum_second.csv": ("pendulum", ""),
}
METHODS = ("own", "trf", "dogbox")


def by_scipy(method: str, problem: Problem, x: np.ndarray, bounds: tuple[np.ndarray, np.ndarray], free: np.ndarray,
             reach: Callable[[np.ndarray], np.ndarray], gain: float, beat: float, iterations: int) -> Solution:  # fmt: skip
    """As levenberg_marquardt, by least_squares."""

    def whole(y: np.ndarray) -> np.ndarray:
        full = x.copy()
        full[free] = y
        return full

    count = len(problem.residuals(x))
    last = [np.inf]

    def residuals(y: np.ndarray) -> np.ndarray:
        try:
            return problem.residuals(whole(y))
        except InputError:
            return np.full(count, np.inf)  # the trust region shrinks

    def jacobian(y: np.ndarray) -> np.ndarray:
        problem.residuals(
            whole(y)
        )  # slopes are those where the residuals were computed last; compiled models keep them
        return problem.slopes(whole(y))[:, free]

    def settled(intermediate_result: Any) -> None:
        before, last[0] = last[0], 2 * intermediate_result.cost
        if before - last[0] < gain:
            raise StopIteration

    if not len(free):
        left = problem.residuals(x)
        problem.accepted()
        return Solution(x, float(left @ left), left, problem.slopes(x))
    found = least_squares(residuals, np.clip(x, *bounds)[free], jacobian, (bounds[0][free], bounds[1][free]), method=method, x_scale="jac",
                          ftol=1e-6, xtol=1e-8, gtol=1e-8, max_nfev=2 * iterations, callback=settled)  # fmt: skip
    at = whole(found.x)
    left = problem.residuals(at)
    problem.accepted()
    return Solution(at, float(left @ left), left, problem.slopes(at))


@contextmanager
def solved_by(method: str) -> Iterator[dict[str, int]]:
    """Fits use a method meanwhile; yields how many fits, evaluations of the residuals and Jacobians there were."""
    counts = {"fits": 0, "residuals": 0, "jacobians": 0}
    solve = levenberg_marquardt if method == "own" else partial(by_scipy, method)

    class Counted:
        def __init__(self, problem: Problem):
            self.problem, self.at = problem, np.zeros(0)

        def residuals(self, x: np.ndarray) -> np.ndarray:
            if not np.array_equal(x, self.at):
                counts["residuals"] += 1
                self.at, self.last = x.copy(), None
                self.last = self.problem.residuals(x)
            if self.last is None:
                raise InputError("cannot be simulated")
            return self.last

        def slopes(self, x: np.ndarray) -> np.ndarray:
            counts["jacobians"] += 1
            return self.problem.slopes(x)

        def accepted(self) -> None:
            self.problem.accepted()

    def counted(problem: Problem, *rest: Any) -> Solution:
        counts["fits"] += 1
        return solve(Counted(problem), *rest)

    fitting.levenberg_marquardt = counted
    try:
        yield counts
    finally:
        fitting.levenberg_marquardt = levenberg_marquardt


def recorded(name: str) -> dict[str, Any]:
    """The verdict on a recording of another laboratory."""
    kind, imposed = RECORDED[name]
    recording = read_recording(SHARED_DATA / "measured" / name)
    test = input_output_experiment(component(kind), list(recording.columns), imposed)
    verdict = investigate(test, [prepare_sampled_run(recording, test)]).verdict
    return {
        "verdict": verdict.verdict,
        "names": sorted(c.family for c in verdict.effects),
        "reduced": verdict.best.reduced,
    }


def rig(name: str) -> dict[str, Any]:
    """The verdict on a solved case of the rig: two runs, and one for validation."""
    folder = SHARED_DATA / "gap_open" / f"case_{name}"
    runs = {
        path.stem: prepare_steer_test_run(read_recording(path), "steer_angle", "steer_torque", "steer_angle_command")
        for path in sorted(folder.glob("*.csv"))
    }
    held = [run for stem, run in runs.items() if stem.startswith("holdout")]
    verdict = select_model(
        HarmonicModel(rig_experiment(read_rig(folder))),
        [run for run in runs.values() if run not in held],
        rig_effects(),
        held,
    )
    return {
        "verdict": verdict.verdict,
        "names": sorted(c.family for c in verdict.effects),
        "reduced": verdict.best.reduced,
    }


def mechanism(number: str) -> dict[str, Any]:
    """The verdict on a simulated mechanism."""
    found = gap_generic.find(draw(int(number)))
    return {"verdict": found["verdict"], "names": found["names"], "reduced": found.get("reduced")}


def run(progress: Callable[..., Iterable], rigs: Sequence[str] = RIGS, mechanisms: Sequence[str] = MECHANISMS, recordings: Sequence[str] = tuple(RECORDED),
        out: str | None = None) -> dict[str, Any]:  # fmt: skip
    """By case and method: verdict, reduced chi-square, counts and seconds; cases whose recordings are not here are left
    out."""
    os.environ["OMP_NUM_THREADS"] = "1"  # counts of other processes would be lost
    cases = [*((mechanism, n) for n in mechanisms), *((recorded, n) for n in recordings if (SHARED_DATA / "measured" / n).exists()),
             *((rig, n) for n in rigs if (SHARED_DATA / "gap_open" / f"case_{n}").exists())]  # fmt: skip
    rows: dict[str, Any] = {}
    for find, name in progress(cases, "cases"):
        row = rows.setdefault(f"{find.__name__} {name}", {})
        for method in METHODS:
            begun = time.process_time()
            with solved_by(method) as counts:
                found = find(name)
            row[method] = {**found, **counts, "seconds": time.process_time() - begun}
        if out:
            Path(out).write_text(json.dumps(rows, indent=1), "utf-8")
    return {"cases": rows, "summary": summary(rows)}


def summary(rows: dict[str, Any]) -> dict[str, Any]:
    """Of SciPy's methods beside the own one: seconds and counts over all cases, verdicts that differ, worse and better
    minima."""
    total = lambda method, key: sum(row[method][key] for row in rows.values())  # noqa: E731
    found = {}
    for method in METHODS:
        pairs = [(row[method], row["own"]) for row in rows.values()]
        numbers = [(a["reduced"], b["reduced"]) for a, b in pairs if a["reduced"] and b["reduced"]]
        found[method] = {**{key: total(method, key) for key in ("fits", "residuals", "jacobians", "seconds")},
                         "other_verdicts": sum((a["verdict"], a["names"]) != (b["verdict"], b["names"]) for a, b in pairs),
                         "worse": sum(a > 1.001 * b for a, b in numbers), "better": sum(b > 1.001 * a for a, b in numbers)}  # fmt: skip
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rig", nargs="*", default=RIGS)
    parser.add_argument("--mechanisms", nargs="*", default=MECHANISMS)
    parser.add_argument("--recorded", nargs="*", default=tuple(RECORDED))
    parser.add_argument("--out")
    given = parser.parse_args()
    print(json.dumps(run(track, given.rig, given.mechanisms, given.recorded, given.out)["summary"], indent=1))
