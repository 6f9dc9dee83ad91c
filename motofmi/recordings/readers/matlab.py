"""MATLAB files up to version 7.2: vectors, matrices, or structs of these, with their units in a struct `units`."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat

from fmus.support.errors import InputError
from motofmi.recordings.table import Format, Table

VALUES, UNITS = ("data", "values", "value"), ("unit", "units")  # fields of a struct that is one channel


def read(path: Path) -> Table:
    """The numeric vectors of the file and of its structs, by name; one of a name that stands twice
    is called `struct.name`. The columns of a matrix, whose longer dimension is the time, are called name_1, name_2;
    beside vectors, a matrix of another length holds no samples.

    units are those of a struct `units` with the same names, beside the vectors or around them: units.steer_angle =
    'deg'. A struct with the fields data and unit is one channel.
    """
    try:
        contents = loadmat(path, squeeze_me=True, simplify_cells=True)
    except NotImplementedError:
        raise InputError("the file is of MATLAB version 7.3, which is not read; save it with -v7") from None
    found = list(_arrays({name: value for name, value in contents.items() if not name.startswith("__")}, "", {}))
    samples = {len(values) for _, _, values, _ in found if values.ndim == 1}
    samples = samples or {max((max(values.shape) for _, _, values, _ in found), default=0)}
    columns = [column for each in found if max(each[2].shape) in samples for column in _columns(*each)]
    names = [name for _, name, _, _ in columns]
    return Table.of(
        (name if names.count(name) == 1 else f"{struct}{name}", given, values)
        for struct, name, given, values in columns
    )


def _arrays(
    fields: dict[str, Any], struct: str, units: dict[str, str]
) -> Iterator[tuple[str, str, np.ndarray, dict[str, str]]]:
    """(struct it is in, name, values, units by name) of every vector (n,) and matrix."""
    own = fields.get("units")
    units = units | own if isinstance(own, dict) else units
    for name, value in fields.items():
        if _is_numeric(value, (1, 2)):
            yield struct, name, value, units
        elif isinstance(value, dict) and value is not own:
            channel = next((value[key] for key in VALUES if _is_numeric(value.get(key), (1,))), None)
            given = next((value[key] for key in UNITS if isinstance(value.get(key), str)), units.get(name, ""))
            if channel is not None:
                yield struct, name, channel, {name: str(given)}
            else:
                yield from _arrays(value, f"{struct}{name}.", units)


def _columns(
    struct: str, name: str, values: np.ndarray, units: dict[str, str]
) -> Iterator[tuple[str, str, str, np.ndarray]]:
    """(struct it is in, name, unit, values (n,)) of a vector, or of every column of a matrix."""
    if values.ndim == 1:
        yield struct, name, str(units.get(name, "")), values
        return
    for place, column in enumerate(values if values.shape[0] < values.shape[1] else values.T, 1):
        yield struct, f"{name}_{place}", str(units.get(f"{name}_{place}", "")), column


def _is_numeric(value: Any, dimensions: tuple[int, ...]) -> bool:
    return isinstance(value, np.ndarray) and value.ndim in dimensions and value.dtype.kind in "fiu" and value.size > 0


FORMAT = Format("MATLAB", (".mat",), read)
