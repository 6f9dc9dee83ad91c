"""Studies of many cases that can be interrupted: one line of JSON per case in cases.jsonl, which is not run again."""

import json
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any


def resumed(
    progress: Callable[..., Iterable], cases: int, out: str | Path | None, one: Callable[[int], dict[str, Any]]
) -> list[dict[str, Any]]:
    """The row of every case, as one(number) gives it, or as out/cases.jsonl holds it already."""
    folder = Path(out or tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    lines = folder / "cases.jsonl"
    done = {row["case"]: row for row in map(json.loads, lines.read_text().splitlines())} if lines.exists() else {}
    for number in progress(range(cases), "blind cases"):
        if number not in done:
            done[number] = {"case": number, **one(number)}
            with lines.open("a") as file:
                file.write(json.dumps(done[number]) + "\n")
    return [done[n] for n in range(cases)]
