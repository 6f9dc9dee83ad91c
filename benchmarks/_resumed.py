"""Studies of many cases on the engine of `motofmi sweep`: on all cores, resumed where they ended.

A case is a run; its row is JSON in the table `runs.parquet` of the folder. A case that is complete is not run again.
"""

import argparse
import json
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from motofmi.studies.run_grid import RunGrid
from motofmi.studies.runner import run_study
from motofmi.studies.runs import Column, Computed, Coordinate, Result, Runs
from motofmi.studies.store import Store
from motofmi.version import __version__

ROW = "row"
NUMBERS = {"first": "number of the first case", "seed": "of the random numbers"}


class Cases(Runs):
    """The cases of a study by their numbers."""

    results: Mapping[str, Result] = {}
    labels = {"case": Column("int64")}  # noqa: RUF012 - as in Runs
    values = {ROW: Column("string")}  # noqa: RUF012 - as in Runs

    def __init__(self, count: int, one: Callable[[int], dict[str, Any]]):
        self.one, self.grid = one, RunGrid(("case",), (count,), (1,))
        self.coordinates = {"case": Coordinate("case", np.arange(count))}

    def labels_of(self, indices: np.ndarray) -> dict[str, Sequence[Any]]:
        """The numbers of the cases."""
        return {"case": indices[:, 0].tolist()}

    def results_of(self, indices: np.ndarray) -> Computed:
        """The row of each case."""
        return Computed({}, {ROW: [json.dumps(self.one(int(k))) for k in indices[:, 0]]})


def resumed(
    cases: int, out: str | Path | None, one: Callable[[int], dict[str, Any]], **identity: Any
) -> list[dict[str, Any]]:
    """The row of every case, as one(number) gives it, or as the folder `out` holds it already.

    identity is what the cases depend on besides their number; a folder with another one is refused. Raises RuntimeError
    with the reasons of cases that failed.
    """
    if not cases:
        return []
    store = Store(Path(out or tempfile.mkdtemp()), Cases(cases, one))
    study = {"kind": "cases", "of": one.__module__, "cases": cases, "version": __version__,
             "identity": {name: str(value) for name, value in identity.items()}}  # fmt: skip
    run_study(store, study, "cases")
    table = pd.read_parquet(store.table)
    failed = table[table["status"] == "failed"]
    if len(failed):
        reasons = "; ".join(f"case {case}: {reason}" for case, reason in zip(failed["case"], failed["reason"], strict=True))
        raise RuntimeError(f"{len(failed)} of {cases} cases in {store.folder} failed: {reasons}")
    return [{"case": int(case), **json.loads(row)} for case, row in zip(table["case"], table[ROW], strict=True)]


def command_line(name: str, description: str | None, cases: int, **numbers: int) -> argparse.Namespace:
    """The arguments of a study that is started by itself: --cases, --out, and those of `NUMBERS` that are given with
    their defaults."""
    parser = argparse.ArgumentParser(prog=f"python -m benchmarks.{name}", description=description)
    parser.add_argument("--cases", type=int, default=cases)
    for number, default in numbers.items():
        parser.add_argument(f"--{number}", type=int, default=default, help=NUMBERS[number])
    parser.add_argument("--out", help="folder of the study, which goes on where it ended")
    return parser.parse_args()
