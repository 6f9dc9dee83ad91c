"""The gap workflow on the official splits of public nonlinear benchmarks, beside published results.

    python -m benchmarks gap_leaderboard --data measured

Training data are given to `find_gap` with a generic component (for the tanks the class of docs/gap.md); it sees nothing
of the test data. The model that it finds is then simulated open loop over the test data, from initial states that fit
their first samples, which are not scored (nonlinearbenchmark.org). It is scored twice: with the values of the workflow,
and with these refitted to the simulation error over the whole training data (`motofmi.gap.validation.open_loop`).

The recordings belong to others and are not part of the project (see `_recordings`).
"""

import argparse
import json
import os
import re
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import motofmi as mf
from benchmarks._memory import peak_memory
from benchmarks._recordings import DATA, Source, missing
from fmus.support.progress import track
from motofmi.gap.preprocessing.sampled_run_preparation import prepare_sampled_run
from motofmi.gap.validation.open_loop import open_loop, refitted_in_open_loop
from motofmi.recordings.recording import Recording

MOST_NUMBERS, MOST_SECONDS = 10, 300.0  # fitted numbers, and seconds of one core, that an entry may take
CLASS = re.compile(r"^    from motofmi import Component.*?^ +}\n", re.MULTILINE | re.DOTALL)
DOCS = Path(__file__).parent.parent / "docs" / "gap.md"


@dataclass(frozen=True)
class Split:
    """A test: its file and samples, the published rms of the best linear and of the best model, and the rms to reach."""

    file: str
    samples: slice
    linear: float | None
    best: float
    target: float


@dataclass(frozen=True)
class Board:
    """A public benchmark. variables are the columns after the time, with their units, of which one is among OUTPUTS.

    searched are the training samples that the workflow fits, held those of its validation run, which are training
    data, too; fitted are those of the refit, in runs of at most `length` samples. window is the number of first samples
    of a test that give its initial states. factor is that from the output's unit to the displayed one.
    """

    source: Source
    variables: Mapping[str, str]
    searched: slice
    held: slice | None
    fitted: slice
    length: int
    window: int
    unit: str
    factor: float
    tests: Mapping[str, Split]


SILVERBOX, CONTINUOUS = "silverbox/whole.csv", "forgi86/sysid-neural-continuous"
MECHANISM, OUTPUTS = {"force": "N", "displacement": "m"}, ("displacement", "level")
BOARDS = {
    "Silverbox": Board(
        Source("biaslab/nsi-silverbox", [SILVERBOX], [], frozenset({"hardening_stiffness"}), "mass_spring_damper"),
        MECHANISM,
        slice(40650, 44746), None, slice(40650, 105712), 8192, 50, "mV", 1e3,
        {"multisine": Split(SILVERBOX, slice(105712, 127400), 6.96, 0.301, 0.31),
         "arrow": Split(SILVERBOX, slice(100, 40575), 14.4, 0.26, 0.40),
         "arrow, no extrapolation": Split(SILVERBOX, slice(100, 32100), 6.58, 0.259, 0.32)}),
    "EMPS": Board(
        Source(CONTINUOUS, ["emps/run.csv"], ["emps/pulses.csv"], frozenset({"coulomb_friction"}), "mass_spring_damper"),
        dict(reversed(MECHANISM.items())), slice(0, 3000), slice(3000, None), slice(None), 10**6, 20, "mm", 1e3,
        {"pulses": Split("emps/pulses.csv", slice(None), 5.53, 2.64, 5.3)}),
    "cascaded tanks": Board(
        Source(CONTINUOUS, ["cascaded_tanks/estimation.csv"], ["cascaded_tanks/validation.csv"], frozenset({"overflow"}),
               "Tanks"),
        {"pump": "V", "level": "V"}, slice(None), None, slice(None), 10**6, 50, "V", 1.0,
        {"validation": Split("cascaded_tanks/validation.csv", slice(None), 0.588, 0.191, 0.36)}),
}  # fmt: skip


def recording(path: Path, samples: slice, variables: Mapping[str, str]) -> Recording:
    """Some samples of a file, with the numbers of its columns read in the units of `variables`."""
    time, *columns = np.loadtxt(path, delimiter=",", skiprows=1)[samples].T
    return Recording(path.stem, time, dict(zip(variables, columns, strict=True)), dict(variables))


def documented(name: str, folder: Path) -> str:
    """PATH.py:CLASS of a component, written as docs/gap.md declares it; a shipped name is itself."""
    block = CLASS.search(DOCS.read_text("utf-8"))
    if block is None or f"class {name}(" not in block[0]:
        return name
    path = folder / "tanks.py"
    path.write_text(re.sub("^    ", "", block[0], flags=re.MULTILINE))
    return f"{path}:{name}"


def entry(board: Board, folder: Path) -> dict[str, Any]:
    """What the workflow finds on the training data, and its scores on the tests."""
    begun, output = _cpu_seconds(), next(n for n in board.variables if n in OUTPUTS)
    training, searched, *held = (
        recording(folder / board.source.fitted[0], samples, board.variables)
        for samples in (board.fitted, board.searched, board.held)
        if samples is not None
    )
    with tempfile.TemporaryDirectory() as made:
        component = documented(board.source.component, Path(made))
        found = mf.find_gap([searched], validation=held, component=component)
    search_seconds = _cpu_seconds() - begun
    best = found.selection.best
    parts = range(0, len(training.time), board.length)
    runs = [prepare_sampled_run(_part(training, slice(i, i + board.length)), best.model.experiment) for i in parts]
    as_found = open_loop(best, runs, board.window)
    models = {"as_found": as_found, "refitted": refitted_in_open_loop(as_found, runs)}
    scores: dict[str, Any] = {}
    for name, test in board.tests.items():
        measured = recording(folder / test.file, test.samples, board.variables)
        scores[name] = {"linear": test.linear, "best": test.best, "target": test.target}
        for way, model in models.items():
            left = model.simulated(measured)[:, 0] - measured[output]
            scores[name][way] = board.factor * float(np.sqrt(np.mean(left[board.window :] ** 2)))
    contents = found.to_dict()
    return {
        "verdict": found.verdict,
        "effects": [{"name": e["name"], "form": e["form"]} for e in found.effects],
        "nearest": [{"name": e.family, "form": e.form} for e in best.model.effects],
        "explained": contents["explained"],
        "explained_of_fitted": 1 - (contents["gap"]["rms"]["after"] / contents["gap"]["rms"]["before"]) ** 2,
        "values": {way: _values(model.model, model.q) for way, model in models.items()},
        "fitted_numbers": models["refitted"].fitted_numbers,
        "samples": {"searched": len(searched.time), "refitted": len(training.time)},
        "cpu_seconds": {"search": search_seconds, "all": _cpu_seconds() - begun},
        "memory_gb": peak_memory() / 1e3,
        "unit": board.unit, "tests": scores, "limitations": found.limitations,
    }  # fmt: skip


def _part(whole: Recording, samples: slice) -> Recording:
    columns = {name: values[samples] for name, values in whole.columns.items()}
    return Recording(f"{whole.name}_{samples.start}", whole.time[samples], columns, whole.units)


def _values(model: Any, q: np.ndarray) -> dict[str, float]:
    """The fitted values by name."""
    values = model.values(q)
    return {name: float(values[name]) for name in model.names}


def _cpu_seconds() -> float:
    """Processor time of this process and of its workers [s]."""
    return sum(os.times()[:4])


def run(
    progress: Callable[..., Iterable], data: str | Path | None = None, boards: Sequence[str] = tuple(BOARDS)
) -> dict[str, Any]:
    """The entry of every board whose recordings are there, and the reasons why the others are skipped."""
    folder = data or os.environ.get(DATA)
    reasons = {name: missing(Path(folder) if folder else None, BOARDS[name].source) for name in boards}
    skipped = {name: reason for name, reason in reasons.items() if reason}
    present = [name for name in boards if not reasons[name]]
    found = {name: entry(BOARDS[name], Path(str(folder))) for name in progress(present, "leaderboards")}
    return {**({"boards": found} if found else {}), "skipped": skipped}


def table(results: Mapping[str, Any]) -> str:
    """The scores as a table of Markdown, from the results of `run`."""
    lines = [
        f"| test | what is found | fitted numbers (at most {MOST_NUMBERS}) | explained | CPU s (at most {MOST_SECONDS:g}) "
        "| rms | rms refitted | to reach | published: linear | best |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, each in results["boards"].items():
        effects = " and ".join(f"`{e['name']}` ({e['form']})" for e in each["effects"]) or f"`{each['verdict']}`"
        for test, score in each["tests"].items():
            small = each["fitted_numbers"] <= MOST_NUMBERS and each["cpu_seconds"]["all"] <= MOST_SECONDS
            reached = "reached" if small and score["refitted"] <= score["target"] else "missed"
            lines.append(
                f"| {name}, {test} | {effects} | {each['fitted_numbers']} | {_share(each)} | "
                f"{each['cpu_seconds']['all']:.0f} | {score['as_found']:.3g} | {score['refitted']:.3g} | "
                f"{score['target']:g} {each['unit']}, {reached} | {score['linear']:g} | {score['best']:g} |"
            )
    return "\n".join(lines) + "\n"


def _share(each: Mapping[str, Any]) -> str:
    """The share of the closable misfit on data that were not fitted, else that of the mean square on fitted ones."""
    explained = each["explained"]
    if not explained:
        return f"{each['explained_of_fitted']:.1%} of the fitted run"
    return f"{explained['share']:.1%} [{explained['low']:.1%}, {explained['high']:.1%}]"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gap_leaderboard", description=__doc__)
    parser.add_argument("--data", metavar="DIR", help=f"folder of recordings (default: environment variable {DATA})")
    parser.add_argument("--boards", nargs="*", choices=list(BOARDS), default=list(BOARDS))
    arguments = parser.parse_args()
    results = run(track, arguments.data, arguments.boards)
    print(json.dumps(results, indent=1))
    if "boards" in results:
        print(table(results), file=sys.stderr)


if __name__ == "__main__":
    main()
