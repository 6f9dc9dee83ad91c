"""Options of commands that run on a batch of recordings: one table with a row for each test."""

import argparse
from typing import Any

from fmus.support.errors import InputError
from motofmi.cli.screen import Screen


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add `--batch`, `--scheduler` and `--workers`."""
    parser.add_argument("--batch", metavar="FOLDER|MANIFEST.csv",
                        help="every test of a folder (a recording is a test, an inner folder a test of several runs), "
                             "or of a CSV manifest with a row for each test and the columns test, recordings, "
                             "validation, ...; the folder --out then holds one table")  # fmt: skip
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a batch: Dask scheduler, as in tcp://host:8786")
    parser.add_argument("--workers", type=int, metavar="N", help="of a batch: processes of this machine")


def run(workflow: str, options: argparse.Namespace, given: dict[str, Any]) -> dict[str, Any]:
    """Run the batch with arguments of the workflow. Raises InputError where recordings are given as well."""
    if options.files:
        raise InputError(f"--batch {options.batch} and recordings are given: expected one of them")
    from motofmi.workflows.batch.batch import OUT, batch  # noqa: PLC0415 - imported on use: it takes 0.3 s

    found = batch(workflow, options.batch, out=options.out or OUT, scheduler=options.scheduler, workers=options.workers,
                  **given)  # fmt: skip
    return found.to_dict()


def show(result: dict[str, Any], screen: Screen) -> None:
    """Print how many tests there are, their verdicts, and why some failed."""
    verdicts = ", ".join(f"{count} {name}" for name, count in result["verdicts"].items())
    screen.print(f"{result['runs']} tests, {result['failed']} failed" + (f": {verdicts}" if verdicts else ""))
    if result["reasons"]:
        screen.table(("test", "reason"), list(result["reasons"].items()))
