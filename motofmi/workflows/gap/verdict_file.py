"""`verdict.json`: written once a verdict is reached, and so far at every stage before, so that an interrupted run leaves what it had."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from identification.gap.naming.decide import Verdict
from scenarios.command_line import to_json, write_text

FILE = "verdict.json"
INTERRUPTED = "Interrupted: this is what was found until then, and no verdict."


def write_verdict(result: dict[str, Any], folder: Path) -> None:
    """The result as the folder's verdict.json, whole or not at all. Raises InputError when the place cannot be written."""
    write_text(folder / FILE, to_json(result) + "\n")


def writing_so_far(folder: Path, say: Callable[[Verdict], dict[str, Any]]) -> Callable[[Verdict], None]:
    """What a search may tell its stages to: it writes them as `unknown`, with the limitation that they are no verdict.

    say gives the result of a verdict.
    """

    def so_far(verdict: Verdict) -> None:
        result = say(replace(verdict, verdict="unknown", effects=[], tied=[], open_form=False))
        write_verdict(result | {"limitations": [INTERRUPTED, *result["limitations"]]}, folder)

    return so_far
