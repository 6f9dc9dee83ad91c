"""One workflow on every test of a folder or manifest, on all cores or a cluster, resumed where it ended."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fmus.support.errors import InputError, unknown
from fmus.support.files import write_atomically
from motofmi.studies.run_grid import RunGrid
from motofmi.studies.runner import run_study
from motofmi.studies.runs import Column, Computed, Coordinate, Result, Runs
from motofmi.studies.store import Store
from motofmi.version import __version__
from motofmi.workflows.batch.manifest import NAME, Test, tests_of
from motofmi.workflows.batch.tables import workflows
from motofmi.workflows.components import component

TESTS = "tests"  # the folder with a folder for each test
OUT = "batch"  # the default folder


class BatchRuns(Runs):
    """A test is a run; `results` are columns of the table only."""

    results: Mapping[str, Result] = {}
    labels = {NAME: Column("string"), "recordings": Column("string")}  # noqa: RUF012 - as in Runs

    def __init__(self, workflow: str, tests: Sequence[Test], arguments: Mapping[str, Any], folder: Path):
        self.workflow, self.tests, self.arguments, self.folder = workflow, tests, dict(arguments), folder.absolute()
        self.grid = RunGrid((NAME,), (len(tests),), (1,))
        self.coordinates = {NAME: Coordinate(NAME, [test.name for test in tests])}
        self.values = workflows()[workflow].columns

    def labels_of(self, indices: np.ndarray) -> dict[str, Sequence[Any]]:
        """The name of each test and its recordings."""
        tests = [self.tests[i] for i in indices[:, 0]]
        return {NAME: [test.name for test in tests],
                "recordings": ["; ".join(path.name for path in test.files["recordings"])
                               for test in tests]}  # fmt: skip

    def results_of(self, indices: np.ndarray) -> Computed:
        """The workflow's results of each test."""
        known = workflows()[self.workflow]
        columns: dict[str, list[Any]] = {name: [] for name in self.values}
        for i in indices[:, 0]:
            test = self.tests[i]
            given = {**self.arguments, **test.arguments, **{name: list(paths) for name, paths in test.files.items()}}
            if known.saves:
                given["out"] = self.folder / TESTS / test.name
            for name, value in known.values(known.function(given.pop("recordings"), **given)).items():
                columns[name].append(value)
        return Computed({}, columns)

    def description(self) -> dict[str, Any]:
        """What the results depend on, with a hash of it."""
        contents = {"kind": f"batch of {self.workflow}", "version": __version__,
                    "arguments": {name: str(value) for name, value in self.arguments.items()},
                    "tests": {test.name: {"files": test.hashes(), "arguments": dict(test.arguments)}
                              for test in self.tests}}  # fmt: skip
        text = json.dumps(contents, sort_keys=True)
        return {**contents, "hash": hashlib.sha256(text.encode()).hexdigest()}


class BatchResult:
    """The table of a batch: one row for each test; `batch` shows an example."""

    def __init__(self, folder: Path):
        self.folder = folder

    @property
    def table(self) -> Any:
        """One row for each test: name, recordings, status, reason, and the values of the workflow
        (pandas.DataFrame)."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        return pd.read_parquet(self.folder / "runs.parquet")

    def write_csv(self) -> Path:
        """Write the table as CSV, too; its path."""
        table = self.table
        return write_atomically(self.folder / "runs.csv",
                                lambda path: table.to_csv(path, index=False, lineterminator="\n"))  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi gap --batch --json`."""
        table = self.table
        counts = table["verdict"].value_counts().sort_index().to_dict() if "verdict" in table else {}
        failed = table[table["status"] == "failed"]
        return {"runs": len(table), "failed": len(failed), "table": str(self.folder / "runs.parquet"),
                "csv": str(self.folder / "runs.csv"), "verdicts": counts,
                "reasons": dict(zip(failed[NAME], failed["reason"], strict=True))}  # fmt: skip

    def to_dataframe(self) -> Any:
        """The table."""
        return self.table

    def __repr__(self) -> str:
        found = self.to_dict()
        verdicts = ", ".join(f"{count} {name}" for name, count in found["verdicts"].items())
        return f"BatchResult({found['runs']} tests, {found['failed']} failed{'; ' + verdicts if verdicts else ''})"


def batch(workflow: str, tests: str | Path, *, out: str | Path = OUT, scheduler: str | None = None,
          workers: int | None = None, **arguments: Any) -> BatchResult:  # fmt: skip
    """Run `gap` or `identify` on every test of a folder or manifest; the table with one row for each test.

    workflow is one of the two. tests is a folder (every recording a test, every inner folder a test with several runs),
    or a CSV manifest (`motofmi.workflows.batch.manifest`). arguments are those of the workflow. out is the folder of
    the results, scheduler the address of a Dask cluster; else so many workers of this machine are used. A test that
    fails is recorded with its reason. An interrupted batch goes on where it ended; other tests or arguments in the same
    folder are refused. Raises InputError before anything runs for what cannot be run.

        >>> from motofmi.frequency_response.excitation import sweep
        >>> from motofmi.recordings.reading import write_recording
        >>> from motofmi.virtual_rig.simulated_rig import steer_test
        >>> write_recording(steer_test(mf.rider("mean_2011"), 0.125, sweep(duration=60)), "recordings/sweep.csv")
        >>> found = mf.batch("identify", "recordings", out="batch", workers=1)
        >>> found.table["test"].tolist(), found.to_dict()["runs"]
        (['sweep'], 1)
        >>> found.to_dataframe().equals(found.table), found.write_csv().name
        (True, 'runs.csv')
    """
    known = workflows()
    if workflow not in known:
        raise unknown("workflow", workflow, known)
    if workers is not None and workers < 1:
        raise InputError(f"workers = {workers}: expected 1 or more")
    folder = Path(out)
    for name in ("component", "vehicle"):
        if arguments.get(name) is not None:
            component(arguments[name])  # raises for an unknown name before anything runs
    runs = BatchRuns(workflow, tests_of(tests, known[workflow].function), arguments, folder)
    run_study(Store(folder, runs), runs.description(), "tests", scheduler, workers)
    found = BatchResult(folder)
    found.write_csv()
    return found
