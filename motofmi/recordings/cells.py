"""Cells of a line of text: what separates them, and whether they hold names, units, numbers or dates."""

import csv
import re
from collections.abc import Iterable
from contextlib import suppress
from datetime import date, datetime, time

from fmus.declaration.units import unit
from fmus.support.errors import InputError

BLANKS = " "  # the mark of cells that any number of blanks separates
# Blanks between cells, and not between a name and its unit in brackets.
BETWEEN = re.compile(r"\s+(?![\[(])")
MISSING = {"", "-", "--", "na", "n/a", "#n/a", "nan", "null", "none"}  # in lower case


def mark_of(line: str) -> str:
    """What separates the cells of a line of samples: a semicolon, a tab, blanks (also beside tabs) or a comma."""
    unquoted = without_quoted(line)
    found = next((each for each in ";\t" if each in unquoted), "")
    written = unquoted.split()
    # "1, 2" has commas between its cells, "1,5 2,5" has decimal commas
    blanks = all(is_sample(each) and not each.endswith(",") for each in written)
    if blanks and len(written) > (unquoted.count(found) + 1 if found else 1):
        return BLANKS
    return found or ","


def cells_of(line: str, delimiter: str) -> list[str]:
    """The cells of a line; in a quoted one the delimiter is a character like any other."""
    if delimiter == BLANKS:
        return BETWEEN.split(line.strip())
    if '"' not in line:
        return line.split(delimiter)
    return next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))


def without_quoted(line: str) -> str:
    return re.sub('"[^"]*"', "", line)


def stripped(cells: Iterable[str]) -> tuple[str, ...]:
    return tuple(cell.strip().strip('"') for cell in cells)


def holds_samples(cells: list[str]) -> bool:
    """Whether more than half of the cells are numbers or dates."""
    return 2 * sum(map(is_sample, cells)) > len(cells)


def holds_names(cells: list[str]) -> bool:
    """Whether a cell is neither empty nor a missing value, and none a number or date."""
    return any(cell.strip().lower() not in MISSING for cell in cells) and not any(map(is_sample, cells))


def is_sample(cell: str) -> bool:
    """Whether a cell holds a number, with a decimal point or comma, or a date."""
    return is_number(cell.replace(",", ".", 1)) or date_of(cell) is not None


def date_of(cell: str) -> datetime | None:
    """The date with a time, or the time of a day, in a cell; None where it holds anything else."""
    written = cell.strip().strip('"')
    if ":" in written:
        with suppress(ValueError):
            return datetime.fromisoformat(written)
        with suppress(ValueError):
            return datetime.combine(date.min, time.fromisoformat(written))
    return None


def holds_units(cells: list[str]) -> bool:
    """Whether a row gives units: at least one that is known, and nothing that is a number but the unit 1."""
    written = [bare(cell) for cell in cells]
    return any(is_unit(cell) for cell in written) and not any(is_number(cell) for cell in written if cell != "1")


def bare(cell: str) -> str:
    """A unit without its brackets; "" where the cell is empty or a dash."""
    return cell.strip().strip('"').strip("[]()").strip("- ")


def is_unit(cell: str) -> bool:
    try:
        unit(cell)
    except InputError:
        return False
    return cell != "1"


def is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
