"""The common form of what readers of files return, and how a reader declares itself."""

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fmus.support.errors import InputError


@dataclass(frozen=True)
class Table:
    """The k columns of a file: names and units, "" where the file gives none, and their numbers in
    blocks of rows (n, k).

    A name that occurs with several units, as of a sensor's voltage and of what it measures, is written with its unit:
    `force [V]` and `force [N]`. The blocks can be read once. NaN is a missing value. expected_bytes is the memory that
    reading all blocks takes, 0 where it is not known beforehand. Raises InputError for columns with the same name and
    unit.
    """

    names: Sequence[str]
    units: Sequence[str]
    blocks: Iterable[np.ndarray]
    expected_bytes: float = 0.0

    def __post_init__(self) -> None:
        names = [
            with_unit(name, given) if self.names.count(name) > 1 else name
            for name, given in zip(self.names, self.units, strict=True)
        ]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise InputError(f"two columns are named {', '.join(twice)}; rename all but one in the file")
        object.__setattr__(self, "names", names)

    @classmethod
    def of(cls, columns: Iterable[tuple[str, str, np.ndarray]]) -> "Table":
        """The table of (name, unit, values (n,)). Raises InputError without any column and for different lengths."""
        columns = list(columns)
        if not columns:
            raise InputError("the file holds no columns of numbers")
        if len({len(values) for _, _, values in columns}) > 1:
            raise InputError(
                f"columns of different lengths: {', '.join(f'{name} {len(values)}' for name, _, values in columns)}"
            )
        names, units, values = zip(*columns, strict=True)
        return cls(names, units, [np.column_stack([np.asarray(v, float) for v in values])])


@dataclass(frozen=True)
class Format:
    """A file format: the suffixes of its files, its reader, and the optional package that the reader imports.

    read gets the path of the file; it raises InputError without the file's name, which the caller puts in front.
    """

    name: str
    suffixes: tuple[str, ...]
    read: Callable[[Path], Table]
    needs: str = ""


def name_and_unit(heading: str) -> tuple[str, str]:
    """`name [unit]` or `name (unit)` as (name, unit); the unit is "" where there is none."""
    match = re.fullmatch(r"\s*(.*?)\s*[\[(]([^\])]*)[\])]\s*", heading)
    return (match[1], match[2].strip()) if match else (heading.strip(), "")


def with_unit(name: str, given: str) -> str:
    """A name with its unit, where there is one."""
    return f"{name} [{given}]" if given else name


def with_time(table: Table, rate: float, left_out: Collection[str] = ()) -> Table:
    """The table with a column `time` [s] of rows at a sampling rate [Hz], the first at 0, and without some columns."""
    kept = [i for i, name in enumerate(table.names) if name not in left_out]

    def blocks() -> Iterator[np.ndarray]:
        first = 0
        for block in table.blocks:
            yield np.column_stack([np.arange(first, first + len(block)) / rate, block[:, kept]])
            first += len(block)

    share = 1 + 1 / len(table.names)
    names, units = ([column[i] for i in kept] for column in (table.names, table.units))
    return Table(["time", *names], ["s", *units], blocks(), share * table.expected_bytes)
