"""Tables of published numbers, kept as text so that each value keeps its printed digits."""

import csv
from pathlib import Path


def table(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file as texts by column.

    Lines that start with # hold the source and remarks and are skipped.
    """
    lines = (line for line in path.read_text("utf-8").splitlines() if not line.startswith("#"))
    return list(csv.DictReader(lines))


def last_digit(printed: str) -> float:
    """One unit of the last printed digit: 0.01 for `-3.56`, 1 for `54`."""
    return 10.0 ** -len(printed.partition(".")[2])
