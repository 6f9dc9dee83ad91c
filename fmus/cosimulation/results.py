"""The rows of a run, written to a CSV file in blocks or kept in memory.

The header is `time [s]` and every output as `instance.variable [unit]`. Every block is flushed: the file is
readable during the run and after it was killed, and memory does not grow with the duration.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from fmus.support.errors import InputError
from fmus.support.files import note_written


def heading(name: str, unit: str) -> str:
    """The heading of a column; without brackets where the unit is unknown."""
    return f"{name} [{unit}]" if unit else name


class Rows:
    """The rows of a run, in the file `path`, or without one in memory, allocated for `expected` rows.

    Raises InputError when it cannot be written.
    """

    def __init__(self, columns: Sequence[str], path: str | Path | None = None, expected: int = 1000):
        self.columns = tuple(columns)
        self.path = Path(path) if path is not None else None
        self._kept, self._count = np.empty((0 if path is not None else expected, len(self.columns))), 0
        self._file: TextIO | None = None
        if self.path is not None:
            try:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                self._file = self.path.open("w", encoding="utf-8", newline="\n")
            except OSError as error:
                raise InputError(
                    f"cannot write {self.path}: {error.strerror}; choose another place for the results"
                ) from None
            note_written(self.path)
            self._file.write(",".join(self.columns) + "\n")
            self._file.flush()

    def write(self, rows: np.ndarray) -> None:
        """Add rows (n, columns)."""
        if self._file is None:
            count = self._count + len(rows)
            if count > len(self._kept):
                self._kept = np.concatenate([self._kept[: self._count], np.empty((count, len(self.columns)))])
            self._kept[self._count : count] = rows
            self._count = count
            return
        self._file.writelines(",".join(map(repr, row)) + "\n" for row in rows.tolist())
        self._file.flush()

    def close(self) -> None:
        if self._file is not None:
            self._file.close()

    @property
    def kept(self) -> np.ndarray:
        """The rows (n, columns) that were kept in memory."""
        return self._kept[: self._count]
