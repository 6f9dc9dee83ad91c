"""Parquet files, as pandas and other data tools write them."""

from pathlib import Path

import numpy as np

from motofmi.recordings.table import Format, Table, name_and_unit


def read(path: Path) -> Table:
    """The numeric columns, and dates as seconds from the first one; units in the names as in CSV, or under `unit` in
    the metadata of the fields."""
    from pyarrow.parquet import read_table  # noqa: PLC0415 - an optional package

    table = read_table(path)
    found = []
    for field, column in zip(table.schema, table.columns, strict=True):
        name, unit = name_and_unit(field.name)
        values = column.to_numpy()
        if values.dtype.kind == "M":
            found.append((name, "s", (values - values[0]) / np.timedelta64(1, "s")))
        elif values.dtype.kind in "fiu":
            found.append((name, unit or (field.metadata or {}).get(b"unit", b"").decode(), values))
    return Table.of(found)


FORMAT = Format("Parquet", (".parquet",), read, needs="pyarrow")
