"""The rows of a run: to a CSV file, written in blocks and flushed, or kept.

The header is `time [s]` and every output as `instance.variable [unit]`. What has been written can be read at
any moment, also when the run is killed; memory does not grow with the duration.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from fmus.errors import InputError


class Rows:
    """Where the rows of a run go: to `path`, or without one into memory. Raises InputError when it cannot be written."""

    def __init__(self, columns: Sequence[str], path: str | Path | None = None):
        self.columns = tuple(columns)
        self.path = Path(path) if path is not None else None
        self._kept: list[np.ndarray] = []
        self._file: TextIO | None = None
        if self.path is not None:
            try:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                self._file = self.path.open("w", encoding="utf-8", newline="\n")
            except OSError as error:
                raise InputError(f"cannot write {self.path}: {error.strerror}; choose another place for the results") from None
            self._file.write(",".join(self.columns) + "\n")
            self._file.flush()

    def write(self, rows: np.ndarray) -> None:
        """Add rows (n, columns)."""
        if self._file is None:
            self._kept.append(rows.copy())
            return
        self._file.writelines(",".join(map(repr, row)) + "\n" for row in rows.tolist())
        self._file.flush()

    def close(self) -> None:
        if self._file is not None:
            self._file.close()

    @property
    def kept(self) -> np.ndarray:
        """The rows (n, columns) that were kept in memory."""
        return np.concatenate(self._kept) if self._kept else np.zeros((0, len(self.columns)))
