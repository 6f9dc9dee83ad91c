"""Text with one row per sample: names, perhaps a row of units, numbers; comma, semicolon, tab or blanks between cells.

Names that occur several times, as of motion capture, are those of groups in the row above: `plate x`. Where no other row holds
names, those of a comment right above the samples count. What else an instrument writes above the names is left out. Dates with times, and times of a day (ISO 8601), are read as
seconds from the first one. numpy parses the numbers. pandas parses three times as fast, but takes half a second to
import, which is the time of 15 MB. Only blocks with missing values, dates, quotes or faults are read cell by cell.
"""

import codecs
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime
from io import StringIO
from itertools import accumulate, islice
from pathlib import Path

import numpy as np

from fmus.support.errors import InputError
from motofmi.recordings.cells import (
    BLANKS,
    MISSING,
    bare,
    cells_of,
    date_of,
    holds_names,
    holds_samples,
    holds_units,
    is_number,
    mark_of,
    stripped,
    without_quoted,
)
from motofmi.recordings.formats import supported
from motofmi.recordings.table import Format, Table, name_and_unit

ROWS = 50_000  # rows of a block
SAMPLE = 1 << 16  # bytes from which the layout is found
EXAMPLE = "a header row of names with units, such as 'time [s],angle [rad],torque [N.m]'"
COMMENT = ("#", "%")  # how a comment begins
SKIPPED = (*COMMENT, "sep=")  # how lines above the header begin: comments, and what a spreadsheet program writes


Row = tuple[int, str]  # the number of a line, from 1 on, and its text


@dataclass(frozen=True)
class Layout:
    """How a text file is written: its encoding, the lines above the numbers, its columns, which of them hold numbers,
    and the first date of those that hold dates."""

    encoding: str
    above: int
    delimiter: str
    decimal_comma: bool
    headings: tuple[str, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    used: tuple[int, ...]
    first_dates: Mapping[int, datetime]

    def number(self, cell: str, column: int) -> float | None:
        """The number in a cell, NaN for a missing value, None for anything else."""
        cell = cell.strip()
        if cell.lower() in MISSING:
            return float("nan")
        if column in self.first_dates:
            stamp = date_of(cell)
            try:
                return None if stamp is None else (stamp - self.first_dates[column]).total_seconds()
            except TypeError:  # only one of them has a time zone
                return None
        try:
            return float(cell.replace(",", ".") if self.decimal_comma else cell)
        except ValueError:
            return None


def read(path: Path) -> Table:
    """The columns of numbers. Columns without a unit whose first cell is text are labels, and left out.

    Raises InputError for a file that is not such a table, while its blocks are read with the line of the first fault.
    """
    with path.open("rb") as file:
        head = file.read(SAMPLE)
    layout = _layout(head, whole=len(head) < SAMPLE)
    rows = path.stat().st_size * head.count(b"\n") / max(len(head), 1)
    # The blocks and the table that is made of them are in memory together.
    return Table([layout.names[i] for i in layout.used], [layout.units[i] for i in layout.used], _blocks(path, layout),
                 2 * 8 * len(layout.used) * rows)  # fmt: skip


def table_of(rows: Iterable[Sequence[str]]) -> Table:
    """The columns of numbers in rows of cells as text, as of a sheet. Raises InputError as `read` does."""
    lines = ["\t".join(re.sub(r'[\t\r\n"]+', " ", cell) for cell in row) for row in rows]
    layout = _layout_of(lines, "utf-8", "\t")
    numbers = _cell_by_cell(lines[layout.above :], layout.above, layout)
    if not len(numbers):
        raise InputError("no rows of numbers below the header")
    return Table([layout.names[i] for i in layout.used], [layout.units[i] for i in layout.used], [numbers])


def _layout(head: bytes, whole: bool) -> Layout:
    encoding = _encoding(head)
    lines = list(StringIO(head.decode(encoding, "replace"), newline=None))
    return _layout_of(lines if whole else lines[:-1], encoding)


def _layout_of(lines: Sequence[str], encoding: str, mark: str = "") -> Layout:
    """The layout of lines, whose cells a mark separates, or one that is found."""
    written = [(number, line.rstrip("\n")) for number, line in enumerate(lines, 1) if line.strip()]
    rows = [(number, line) for number, line in written if not line.lower().startswith(SKIPPED)]
    if not rows:
        raise InputError(f"the file is empty; expected {EXAMPLE}")
    if not mark and mark_of(rows[-1][1]) == BLANKS:
        mark = BLANKS
    every = _with_names_of_comment(rows, written, mark)
    rows = every[_names_of(every, mark) or 0 :]
    above, heading = rows.pop(0)
    delimiter = mark or max(",;\t", key=without_quoted(heading).count)
    headings = stripped(cells_of(heading, delimiter))
    if len(set(headings)) < len(headings) and len(every) > len(rows) + 1:
        headings = _in_groups(headings, stripped(cells_of(every[-len(rows) - 2][1], delimiter)))
    if all(is_number(name) for name in headings):
        raise InputError(f"line {above} holds numbers, expected {EXAMPLE}")
    names, units = (tuple(part) for part in zip(*map(name_and_unit, headings), strict=True))
    if rows and holds_units(cells := cells_of(rows[0][1], delimiter)) and len(cells) == len(names):
        above = rows.pop(0)[0]
        units = tuple(given or bare(cell) for given, cell in zip(units, cells, strict=True))
    first = cells_of(rows[0][1], delimiter) if rows else []
    first = first if len(first) == len(names) else [""] * len(names)
    decimal_comma = _decimal_comma([row for _, row in rows if delimiter != "," or '"' in row], delimiter)
    dates = {i: stamp for i, cell in enumerate(first) if not is_number(cell) and (stamp := date_of(cell)) is not None}
    units = tuple("s" if i in dates else given for i, given in enumerate(units))
    layout = Layout(encoding, above, delimiter, decimal_comma, headings, names, units, (), dates)
    used = tuple(i for i, name in enumerate(names) if name and (units[i] or layout.number(first[i], i) is not None))
    return replace(layout, used=used)


def _in_groups(headings: tuple[str, ...], above: tuple[str, ...]) -> tuple[str, ...]:
    """The names after those of their groups, from the row above, in which an empty cell belongs to the group before it;
    themselves where the row does not name groups."""
    if len(above) != len(headings) or not holds_names(list(above)):
        return headings
    groups: Iterator[str] = accumulate(above, lambda group, cell: cell or group)
    return tuple(f"{group} {name}".strip() for group, name in zip(groups, headings, strict=True))


def _with_names_of_comment(rows: list[Row], written: list[Row], mark: str) -> list[Row]:
    """The rows themselves where one holds the names, or where no comment above them does; otherwise with these comments.
    written are the rows with their comments."""
    if _names_of(rows, mark) is not None:
        return rows
    commented = [(number, line.lstrip("".join(COMMENT))) for number, line in written if number < rows[0][0]]
    return rows if _names_of([*commented, *rows], mark) is None else [*commented, *rows]


def _names_of(rows: list[Row], mark: str) -> int | None:
    """The index of the row of the names, whose cells a mark separates, or one that is found; None where none is.

    The samples begin with the first row that has as many cells as the last one, more than half of them numbers or
    dates; where the first row has another number of cells, after the last such row. The names are in the row before,
    above those of the units.
    """
    delimiter = mark or mark_of(rows[-1][1])
    cells = [cells_of(line, delimiter) for _, line in rows]
    alike = [len(row) == len(cells[-1]) for row in cells]
    if len(cells[-1]) < 2:
        return None
    first = 0 if alike[0] else len(rows) - alike[::-1].index(False)
    samples = next((i for i in range(first, len(rows)) if alike[i] and holds_samples(cells[i])), len(rows))
    names = samples - 1 - int(samples - 1 > first and holds_units(cells[samples - 1]))
    return names if first <= names < samples < len(rows) and alike[names] and holds_names(cells[names]) else None


def _encoding(head: bytes) -> str:
    if head.startswith(codecs.BOM_UTF8):
        return "utf-8-sig"
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    if b"\0" in head:
        raise InputError(f"neither text nor a file with one of the suffixes {supported()}")
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)  # incremental: the last character may be cut off
    except UnicodeDecodeError:
        return "cp1252"  # what Windows programs write in Western Europe; Latin-1 differs in control characters alone
    return "utf-8"


def _decimal_comma(rows: list[str], delimiter: str) -> bool:
    """Whether numbers have decimal commas. Raises InputError where some have points, as separators of
    thousands also are."""
    cells = [cell for row in rows for cell in cells_of(row, delimiter)] if any("," in row for row in rows) else []
    found = any(_has_mark(cell, ",") for cell in cells)
    if found and any(_has_mark(cell, ".") for cell in cells):
        raise InputError(
            "numbers have decimal commas and decimal points; write all with decimal points, without separators of "
            "thousands"
        )
    return found


def _has_mark(cell: str, mark: str) -> bool:
    return mark in cell and is_number(cell.replace(mark, ".", 1))


def _blocks(path: Path, layout: Layout) -> Iterator[np.ndarray]:
    with path.open(encoding=layout.encoding, errors="replace") as file:
        number, found = layout.above, False
        for _ in range(layout.above):
            file.readline()
        while lines := list(islice(file, ROWS)):
            if any(line.strip() for line in lines):
                found = True
                yield _block(lines, number, layout)
            number += len(lines)
    if not found:
        raise InputError("no rows of numbers below the header")


def _block(lines: list[str], above: int, layout: Layout) -> np.ndarray:
    """The numbers (n, columns) of lines below others."""
    columns = None if len(layout.used) == len(layout.names) else layout.used
    rows = (line.replace(",", ".") for line in lines) if layout.decimal_comma else lines
    if not layout.first_dates and '"' not in lines[0]:
        with suppress(ValueError):
            delimiter = None if layout.delimiter == BLANKS else layout.delimiter
            block = np.loadtxt(rows, delimiter=delimiter, usecols=columns, ndmin=2, comments=None)
            if block.shape[1] == len(layout.used):
                return block
    return _cell_by_cell(lines, above, layout)


def _cell_by_cell(lines: list[str], above: int, layout: Layout) -> np.ndarray:
    """Numbers (n, columns), NaN where a value is missing. Raises InputError for the first cell or
    line that is faulty."""
    rows = []
    for number, line in enumerate(lines, above + 1):
        if not line.strip():
            continue
        cells = cells_of(line.rstrip("\n"), layout.delimiter)
        if len(cells) != len(layout.names):
            raise InputError(f"line {number} has {len(cells)} columns, the header has {len(layout.names)}")
        values = [layout.number(cells[i], i) for i in layout.used]
        if None in values:
            column = layout.used[values.index(None)]
            raise InputError(_fault(number, layout.headings[column], cells[column].strip()))
        rows.append(values)
    return np.array(rows, float)


def _fault(line: int, heading: str, cell: str) -> str:
    fix = " (a decimal comma? the rows above have decimal points)" if is_number(cell.replace(",", ".")) else ""
    return f"line {line}, column {heading!r}: {cell!r} is not a number{fix}"


FORMAT = Format("text", (".csv", ".txt", ".dat", ".tsv"), read)
