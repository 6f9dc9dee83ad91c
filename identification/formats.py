"""Recordings in the formats of laboratories, through the libraries that know them.

Each reader gives the columns by header `name [unit]` and notes, as the CSV reader does. MATLAB files need
nothing more than scipy, up to version 7.2; the others come with `pip install motofmi[formats]`.
"""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
from scipy.io import loadmat

from fmus.errors import InputError, MissingToolError
from identification.reduction import reduced

Columns = dict[str, np.ndarray]
Table = tuple[Columns, tuple[str, ...]]
Reader = Callable[..., Table]  # (path, rate [Hz] or None, name of the time's column)


def _library(name: str, path: Path) -> ModuleType:
    try:
        return import_module(name)
    except ImportError:
        raise MissingToolError(f"reading {path.name} needs {name}: pip install motofmi[formats]") from None


def read_matlab(path: Path) -> Columns:
    """The vectors of a .mat file; a variable `units` (a struct) gives their units by name."""
    try:
        contents = loadmat(path, squeeze_me=True, simplify_cells=True)
    except NotImplementedError:
        raise InputError(f"{path} is a MATLAB 7.3 file; save it with -v7") from None
    except ValueError as error:
        raise InputError(f"{path} is not a MATLAB file: {error}") from None
    units = contents.get("units", {})
    vectors = {n: v for n, v in contents.items() if isinstance(v, np.ndarray) and v.ndim == 1 and v.dtype.kind in "fiu"}
    return {_header(name, units.get(name, "")): np.asarray(v, float) for name, v in vectors.items()}


def read_uff(path: Path) -> Columns:
    """The time responses of a universal file (data set 58): name from id1, unit from the ordinate's label."""
    contents = _library("pyuff", path).UFF(str(path))
    sets = contents.read_sets()
    columns: Columns = {}
    for data in [sets] if isinstance(sets, dict) else sets:
        if data.get("type") == 58 and data.get("func_type") == 1:
            columns.setdefault("time [s]", np.asarray(data["x"], float))
            columns[_header(data["id1"].strip(), data.get("ordinate_axis_units_lab", "").strip())] = np.asarray(data["data"], float)
    return columns


def read_mdf(path: Path) -> Columns:
    """The channels of an MDF4 file on the time base of the fastest one."""
    with _library("asammdf", path).MDF(path) as file:
        signals = [file.get(group=g, index=i) for g, group in enumerate(file.groups) for i, channel in enumerate(group.channels)
                   if channel.channel_type not in (2, 3)]  # fmt: skip
    signals = [s for s in signals if s.samples.dtype.kind in "fiu" and s.samples.ndim == 1]
    if not signals:
        return {}
    base = max(signals, key=lambda s: len(s.timestamps)).timestamps
    columns = {"time [s]": np.asarray(base, float)}
    for signal in signals:
        if not np.array_equal(signal.timestamps, base):
            signal = signal.interp(base)
        columns[_header(signal.name, signal.unit)] = np.asarray(signal.samples, float)
    return columns


def read_parquet(path: Path) -> Columns:
    """The numeric columns of a Parquet file; units in the names, as in CSV, or in the fields' metadata."""
    table = _library("pyarrow.parquet", path).read_table(path)
    columns: Columns = {}
    for field, column in zip(table.schema, table.columns, strict=True):
        unit = (field.metadata or {}).get(b"unit", b"").decode()
        values = column.to_numpy()
        if values.dtype.kind in "fiu":
            columns[_header(field.name, unit)] = np.asarray(values, float)
    return columns


def _header(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _reading(read: Callable[[Path], Columns]) -> Reader:
    """The reader with checks that serve every format: one length, reduction where it is asked for."""

    def table(path: Path, rate: float | None = None, time: str = "time") -> Table:
        if not path.exists():
            raise InputError(f"cannot read {path}: no such file")
        try:
            columns = read(path)
        except (InputError, MissingToolError):
            raise
        except Exception as error:
            raise InputError(f"{path} is not a valid {path.suffix} file: {type(error).__name__}: {error}") from None
        lengths = {name: len(values) for name, values in columns.items()}
        if len(set(lengths.values())) > 1:
            raise InputError(f"{path}: columns of different lengths: {', '.join(f'{n} {k}' for n, k in lengths.items())}")
        if not columns:
            raise InputError(f"{path} holds no columns of numbers")
        if rate is None:
            return columns, ()
        rows, notes = reduced(iter([np.column_stack(list(columns.values()))]), rate, list(columns), time)
        return dict(zip(columns, rows.T, strict=True)), notes

    return table


READERS: dict[str, Reader] = {
    ".mat": _reading(read_matlab),
    ".uff": _reading(read_uff),
    ".unv": _reading(read_uff),
    ".mf4": _reading(read_mdf),
    ".parquet": _reading(read_parquet),
}
