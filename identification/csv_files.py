"""CSV with one header row, read by numpy's C reader, and reduced on the way in where that is wanted."""

import warnings
from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np

from fmus.errors import InputError
from identification.memory import available_memory
from identification.reduction import reduced

CHUNK = 50_000  # rows read at once while reducing
EXAMPLE = "a header row such as 'time [s],steer_angle [rad],steer_torque [N.m]'"
Columns = dict[str, np.ndarray]


def read_csv(path: Path, rate: float | None = None, time: str = "time") -> tuple[Columns, tuple[str, ...]]:
    """The columns by header, and what was done to them; `time` names the time's column. Raises InputError with the line of the first fault."""
    headers, delimiter, skipped = _header(path)
    kept = _not_labels(path, headers, delimiter, skipped)
    names = headers if kept is None else [headers[i] for i in kept]
    try:
        if rate is None:
            _check_memory(path, skipped, len(names))
            return dict(zip(names, _numbers(path, delimiter, skipped, columns=kept).T, strict=True)), ()
        with path.open(encoding="utf-8-sig") as file:
            for _ in range(skipped):
                file.readline()
            table, note = reduced(_chunks(file, delimiter, kept), rate, names, time)
            return dict(zip(names, table.T, strict=True)), note
    except MemoryError:
        raise _too_large(path) from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise _first_fault(path, headers, delimiter, skipped, names) from None


def _header(path: Path) -> tuple[list[str], str, int]:
    """(names, delimiter, lines before the numbers)."""
    try:
        with path.open(encoding="utf-8-sig") as file:
            found = next(((i, line) for i, line in enumerate(file, 1) if line.strip() and not line.startswith("#")), None)
    except UnicodeDecodeError:
        raise InputError(f"{path} is no text file; formats by suffix: .csv, .mat, .uff, .unv, .mf4, .parquet") from None
    if found is None:
        raise InputError(f"{path} is empty; expected {EXAMPLE}")
    number, line = found
    delimiter = max(",;\t", key=line.count)
    names = [name.strip().strip('"') for name in line.split(delimiter)]
    if all(_is_number(name) for name in names):
        raise InputError(f"{path}: line {number} holds numbers, expected {EXAMPLE}")
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise InputError(f"{path}: the header names {', '.join(sorted(twice))} twice")
    return names, delimiter, number


def _not_labels(path: Path, headers: list[str], delimiter: str, skipped: int) -> list[int] | None:
    """The columns to read, None for all: one without a unit whose first cell is no number is a label."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        first = next((line for number, line in enumerate(file, 1) if number > skipped and line.strip()), "")
    cells = first.rstrip("\n").split(delimiter)
    if len(cells) != len(headers):
        return None
    kept = [i for i, (name, cell) in enumerate(zip(headers, cells, strict=True)) if "[" in name or "(" in name or _is_number(cell)]
    return None if len(kept) == len(headers) else kept


def _numbers(source, delimiter: str, skipped: int = 0, rows: int | None = None, columns: list[int] | None = None) -> np.ndarray:
    """Numbers (n, columns); ValueError at the first cell that is none, and without any."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # that there is no data is said below
        table = np.loadtxt(source, delimiter=delimiter, skiprows=skipped, max_rows=rows, usecols=columns, ndmin=2, comments=None, encoding="utf-8-sig")
    if not table.size:
        raise ValueError("no rows")
    return table


def _chunks(file, delimiter: str, columns: list[int] | None) -> Iterator[np.ndarray]:
    while (line := file.readline()).strip():
        yield _numbers(chain([line], file), delimiter, rows=CHUNK, columns=columns)


def _check_memory(path: Path, skipped: int, columns: int) -> None:
    """numpy's reader grows its array by a quarter at a time and copies it: twice the numbers' size at worst."""
    with path.open("rb") as file:
        for _ in range(skipped):
            file.readline()
        sample = file.read(65536)
    rows = path.stat().st_size * sample.count(b"\n") / max(len(sample), 1)
    if 2 * 8 * columns * rows > available_memory():
        raise _too_large(path)


def _too_large(path: Path) -> InputError:
    return InputError(f"{path} ({path.stat().st_size / 1e6:.0f} MB) does not fit in the {available_memory() / 1e6:.0f} MB of memory left; "
                      "reduce it while it is read with rate=128 (--rate 128) [Hz]")  # fmt: skip


def _first_fault(path: Path, headers: list[str], delimiter: str, skipped: int, read: list[str]) -> InputError:
    """What is wrong in the first line that is not a row of numbers."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        for number, line in enumerate(file, 1):
            if number <= skipped or not line.strip():
                continue
            cells = line.rstrip("\n").split(delimiter)
            if len(cells) != len(headers):
                return InputError(f"{path}: line {number} has {len(cells)} columns, the header has {len(headers)}")
            for name, cell in zip(headers, cells, strict=True):
                if name in read and not _is_number(cell):
                    fix = " (a decimal comma? write decimal points)" if _is_number(cell.replace(",", ".")) else ""
                    return InputError(f"{path}: line {number}, column {name!r}: {cell.strip()!r} is not a number{fix}")
    return InputError(f"{path}: no rows of numbers below the header")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
