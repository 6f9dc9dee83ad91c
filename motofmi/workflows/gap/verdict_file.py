"""`verdict.json`: written once a verdict is reached, and so far at every stage before, so that an interrupted run
leaves what it had."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from fmus.support.files import write_text
from fmus.support.plain_json import to_json
from motofmi.gap.selection.model_selection import Verdict

FILE = "verdict.json"
INTERRUPTED = "Interrupted: this is what was known until then, and no verdict."


def write_verdict(result: dict[str, Any], folder: Path) -> None:
    """The result as the folder's verdict.json, whole or not at all. Raises InputError when the
    place cannot be written."""
    write_text(folder / FILE, to_json(result) + "\n")


def writing_progress(folder: Path, say: Callable[[Verdict], dict[str, Any]]) -> Callable[[Verdict], None]:
    """A callback that writes what is known after a stage as `unknown`, with the limitation that it is no verdict.

    say gives the contents of a verdict.
    """

    def so_far(verdict: Verdict) -> None:
        result = say(replace(verdict, verdict="unknown", effects=[], tied=[], unspecified_form=False))
        write_verdict(result | {"limitations": [INTERRUPTED, *result["limitations"]]}, folder)

    return so_far
