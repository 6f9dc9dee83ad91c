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
    is called `struct.name`. The columns of a matrix, whose longer dimension is the time, are called name_1, name_2; a
    matrix that is shorter than a vector holds no samples.

    units are those of a struct `units` with the same names, beside the vectors or around them: units.steer_angle =
    'deg'. A struct with the fields data and unit is one channel.
    """
    try:
        contents = loadmat(path, squeeze_me=True, simplify_cells=True)
    except NotImplementedError:
        raise InputError("the file is of MATLAB version 7.3, which is not read; save it with -v7") from None
    fields = {name: value for name, value in contents.items() if not name.startswith("__")}
    longest = max((len(values) for *_, values in _vectors(fields, "", {})), default=0)
    found = list(_vectors(fields, "", {}, shortest=longest))
    names = [name for _, name, _, _ in found]
    return Table.of(
        (name if names.count(name) == 1 else f"{struct}{name}", given, values) for struct, name, given, values in found
    )


def _vectors(
    fields: dict[str, Any], struct: str, units: dict[str, str], shortest: int = 0
) -> Iterator[tuple[str, str, str, np.ndarray]]:
    """(struct it is in, name, unit, values (n,)) of every vector, and of every column of a matrix that is not shorter
    than `shortest`."""
    own = fields.get("units")
    units = units | own if isinstance(own, dict) else units
    for name, value in fields.items():
        if _is_vector(value):
            yield struct, name, str(units.get(name, "")), value
        elif _is_matrix(value) and max(value.shape) >= shortest:
            for place, column in enumerate(value if value.shape[0] < value.shape[1] else value.T, 1):
                yield struct, f"{name}_{place}", str(units.get(f"{name}_{place}", "")), column
        elif isinstance(value, dict) and value is not own:
            channel = next((value[key] for key in VALUES if _is_vector(value.get(key))), None)
            given = next((value[key] for key in UNITS if isinstance(value.get(key), str)), units.get(name, ""))
            if channel is not None:
                yield struct, name, str(given), channel
            else:
                yield from _vectors(value, f"{struct}{name}.", units, shortest)


def _is_vector(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype.kind in "fiu"


def _is_matrix(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.ndim == 2 and value.dtype.kind in "fiu" and value.size > 0


FORMAT = Format("MATLAB", (".mat",), read)
