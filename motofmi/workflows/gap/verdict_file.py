"""`verdict.json`: written after every stage, so that an interrupted run leaves its intermediate results."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from fmus.support.files import write_text
from fmus.support.plain_json import to_json
from motofmi.gap.selection.result import Verdict
from motofmi.gap.selection.within_time import INTERRUPTED

FILE = "verdict.json"


def write_verdict(result: dict[str, Any], folder: Path) -> None:
    """Write the result as verdict.json into the folder, atomically. Raises InputError if it cannot be written."""
    write_text(folder / FILE, to_json(result) + "\n")


def writing_progress(folder: Path, contents: Callable[[Verdict], dict[str, Any]]) -> Callable[[Verdict], None]:
    """A callback that writes the state after a stage as `unknown`, with the limitation that it is no verdict.

    contents gives the contents of verdict.json for a verdict.
    """

    def on_progress(verdict: Verdict) -> None:
        result = contents(verdict.as_unknown())
        write_verdict(result | {"limitations": [INTERRUPTED, *result["limitations"]]}, folder)

    return on_progress
