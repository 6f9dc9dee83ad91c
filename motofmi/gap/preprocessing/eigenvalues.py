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
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = [
                row for row in csv.reader(file) if any(cell.strip() for cell in row) and not row[0].startswith("#")
            ]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from None
    if len(lines) < 1 + FEWEST_ROWS:
        raise InputError(
            f"{path}: {max(len(lines) - 1, 0)} eigenvalues; expected at least {FEWEST_ROWS} below the header {EXAMPLE}"
        )
    places = _columns(path, lines[0])
    names = [row[places["mode"][0]].strip() if "mode" in places else "" for row in lines[1:]]
    numbers = {n: np.array([_number(path, i, row, n, *places[n]) for i, row in enumerate(lines[1:], 2)]) for n in UNITS}
    value = numbers["real"] + 1j * np.abs(numbers["imag"])
    real_error = numbers["real_se"]
    imag_error = np.where(value.imag > 0, numbers["imag_se"], 1.0)
    for name, errors in (("real_se", real_error), ("imag_se", imag_error)):
        if not (errors > 0).all():
            row = int(np.flatnonzero(~(errors > 0))[0])
            raise InputError(
                f"{path}: line {row + 2}, {name} is {errors[row]:g}; expected a standard error above zero [1/s]"
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


def _number(path: Path, line: int, row: Sequence[str], name: str, place: int, given: str) -> float:
    """The number in a row of a file, in the unit of its column; the error of a missing imaginary part is 0."""
    cell = row[place].strip() if place < len(row) else ""
    if not cell and name == "imag_se":
        return 0.0
    try:
        value = _converted(float(cell), given, name)
    except ValueError as error:
        reason = str(error) if isinstance(error, InputError) else f"{cell!r} is not a number"
        raise InputError(f"{path}: line {line}, column {name}: {reason}") from None
    if not np.isfinite(value):
        raise InputError(f"{path}: line {line}, column {name}: {cell!r} is not finite")
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
