"""Measured eigenvalues over an input (a vehicle's speed), with standard errors and the names of their modes.

    speed [m/s], mode, real [1/s], imag [1/s], real_se [1/s], imag_se [1/s]

Units may be left out, and other units are converted: rad/s or Hz (times 2 pi) of the imaginary part, km/h of the speed.
A row is one eigenvalue with Im >= 0; a real root has imag 0, which is then not compared. `mode` may be empty. Rows with
one speed and one name of a mode are repeated measurements.
"""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fmus.declaration.units import convert, unit
from fmus.support.errors import InputError
from motofmi.recordings.table import name_and_unit

UNITS = {"speed": "m/s", "real": "1/s", "imag": "1/s", "real_se": "1/s", "imag_se": "1/s"}
EXAMPLE = "speed [m/s],mode,real [1/s],imag [1/s],real_se [1/s],imag_se [1/s]"
FEWEST_ROWS = 4


@dataclass(frozen=True)
class MeasuredEigenvalues:
    """Measured eigenvalues (n,) [1/s] over an input (n,), the speed [m/s].

    mode (n,) are the names of the modes, "" where unknown; real_error and imag_error (n,) are standard errors [1/s].
    shapes are the right and left eigenvectors (n, nx) of the modes of these names in a base before any fit, NaN where
    there is none; without shapes the names are not used. As a run of the gap workflow the data are the real parts,
    followed by the imaginary parts of the oscillating eigenvalues.
    """

    name: str
    over: np.ndarray
    mode: tuple[str, ...]
    value: np.ndarray
    real_error: np.ndarray
    imag_error: np.ndarray
    shapes: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def oscillates(self) -> np.ndarray:
        """Whether an eigenvalue (n,) is complex."""
        return self.value.imag > 0

    @property
    def data(self) -> np.ndarray:
        """The real parts, then the imaginary parts of the oscillating eigenvalues, (m,) [1/s]."""
        return self.parts(self.value)

    @property
    def deviation(self) -> np.ndarray:
        """The standard deviation (m,) of the data [1/s]."""
        return np.concatenate([self.real_error, self.imag_error[self.oscillates]])

    def parts(self, value: np.ndarray) -> np.ndarray:
        """Real and imaginary parts (m, ...) of eigenvalues (n, ...), in the order of the data."""
        return np.concatenate([value.real, value[self.oscillates].imag])

    @property
    def labels(self) -> tuple[np.ndarray, list[str], list[str]]:
        """For each datum: the input (m,), the mode, and `real` or `imag`."""
        complex_ = np.flatnonzero(self.oscillates)
        over = np.concatenate([self.over, self.over[complex_]])
        modes = [*self.mode, *(self.mode[i] for i in complex_)]
        return over, modes, ["real"] * len(self.over) + ["imag"] * len(complex_)


def read_eigenvalues(path: str | Path) -> MeasuredEigenvalues:
    """The eigenvalues of a CSV file.

    Raises InputError with the line, what was given and what was expected.
    """
    path = Path(path)
    rows = _rows(path)
    if len(rows) < 1 + FEWEST_ROWS:
        raise InputError(
            f"{path}: {max(len(rows) - 1, 0)} eigenvalues; expected at least {FEWEST_ROWS} below the header {EXAMPLE}"
        )
    header, *rows = rows
    places = _columns(path, header.cells)
    names = [row.cell(places["mode"][0]) if "mode" in places else "" for row in rows]
    numbers = {n: np.array([_number(path, row, n, *places[n]) for row in rows]) for n in UNITS}
    value = numbers["real"] + 1j * np.abs(numbers["imag"])
    real_error = numbers["real_se"]
    imag_error = np.where(value.imag > 0, numbers["imag_se"], 1.0)
    for name, errors in (("real_se", real_error), ("imag_se", imag_error)):
        if not (errors > 0).all():
            first = int(np.flatnonzero(~(errors > 0))[0])
            raise InputError(
                f"{path}: line {rows[first].line}, {name} is {errors[first]:g}; expected a standard error above zero "
                "[1/s]"
            )
    return MeasuredEigenvalues(path.name, numbers["speed"], tuple(names), value, real_error, imag_error)


def has_eigenvalues(path: str | Path) -> bool:
    """Whether a CSV file holds eigenvalues, by its header."""
    try:
        with Path(path).open(encoding="utf-8-sig", errors="replace") as file:
            header = next((line for line in file if line.strip() and not line.startswith("#")), "")
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
    return {"real", "imag"} <= {name_and_unit(cell)[0] for cell in header.split(",")}


@dataclass(frozen=True)
class _Row:
    """A row with the number of its line in the file, comments and empty lines counted."""

    line: int
    cells: Sequence[str]

    def cell(self, place: int) -> str:
        """The text of a cell; empty where the row is shorter."""
        return self.cells[place].strip() if place < len(self.cells) else ""


def _rows(path: Path) -> list[_Row]:
    """The rows of a file that are neither comments nor empty, the header first."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            every = [_Row(reader.line_num, cells) for cells in reader]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from None
    return [row for row in every if any(cell.strip() for cell in row.cells) and not row.cells[0].startswith("#")]


def _columns(path: Path, header: Sequence[str]) -> dict[str, tuple[int, str]]:
    """The index and the unit of each column."""
    found = {}
    for place, cell in enumerate(header):
        name, given = name_and_unit(cell)
        found[name] = (place, given or UNITS.get(name, ""))
    missing = [n for n in UNITS if n not in found]
    if missing:
        raise InputError(f"{path}: no column {', '.join(missing)}; expected {EXAMPLE}")
    return found


def _number(path: Path, row: _Row, name: str, place: int, given: str) -> float:
    """The number in a row of a file, in the unit of its column; the error of a missing imaginary part is 0."""
    cell = row.cell(place)
    if not cell and name == "imag_se":
        return 0.0
    try:
        value = _converted(float(cell), given, name)
    except ValueError as error:
        reason = str(error) if isinstance(error, InputError) else f"{cell!r} is not a number"
        raise InputError(f"{path}: line {row.line}, column {name}: {reason}") from None
    if not np.isfinite(value):
        raise InputError(f"{path}: line {row.line}, column {name}: {cell!r} is not finite")
    return value


def _converted(value: float, given: str, name: str) -> float:
    """The value in the unit of its column.

    An imaginary part is an angular frequency, so that one in Hz is multiplied by 2 pi. A real part is a rate of decay,
    which has no cycles. Raises InputError for any other unit.
    """
    if UNITS[name] != "1/s":
        return convert(value, given, UNITS[name])
    if unit(given) == unit("Hz"):
        if name not in ("imag", "imag_se"):
            raise InputError("Hz is no unit of a real part; expected 1/s or rad/s")
        return 2 * np.pi * value
    turning = unit(given).exponents == unit("rad/s").exponents
    return convert(value, given, "rad/s" if turning else "1/s")
