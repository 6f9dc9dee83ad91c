"""Sheets of Excel workbooks, read as text with one row per sample is: names, perhaps a row of units, numbers."""

import warnings
from datetime import date, datetime, time
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from fmus.support.errors import InputError
from motofmi.recordings.readers.csv_text import table_of
from motofmi.recordings.table import Format, Table

LARGEST = 2**31  # bytes to which the parts of a workbook may unpack


def read(path: Path) -> Table:
    """The first sheet that is such a table; formulas have the values that were saved. Raises InputError where none is,
    with the reason of the first."""
    from openpyxl import load_workbook  # noqa: PLC0415 - an optional package

    with ZipFile(path) as archive:
        if sum(member.file_size for member in archive.infolist()) > LARGEST:
            raise InputError(f"the workbook unpacks to more than {LARGEST} bytes")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of formats and validation rules of cells, which do not change their values
        book = load_workbook(path, read_only=True, data_only=True)
    reasons: list[str] = []
    try:
        for sheet in book.worksheets:
            try:
                return table_of([_text(cell) for cell in row] for row in sheet.iter_rows(values_only=True))
            except InputError as error:
                reasons.append(f"sheet {sheet.title!r}: {error}")
    finally:
        book.close()
    raise InputError(reasons[0] if reasons else "the workbook has no sheet")


def _text(cell: Any) -> str:
    """A cell as text: dates as in ISO 8601."""
    return "" if cell is None else cell.isoformat() if isinstance(cell, date | datetime | time) else str(cell)


FORMAT = Format("Excel", (".xlsx", ".xlsm"), read, needs="openpyxl")
