"""MDF4 files of measurement systems (ASAM)."""

from pathlib import Path
from typing import Any

from motofmi.recordings.table import Format, Table

MASTERS = (2, 3)  # types of channels that hold the time, measured and calculated


def read(path: Path) -> Table:
    """The channels, on the time base of the one with most samples."""
    from asammdf import MDF  # noqa: PLC0415 - an optional package

    with MDF(path) as file:
        groups: Any = file.groups  # of version 3 or 4
        signals = [file.get(group=g, index=i) for g, group in enumerate(groups)
                   for i, channel in enumerate(group.channels)
                   if channel.channel_type not in MASTERS]  # fmt: skip
    signals = [s for s in signals if s.samples.dtype.kind in "fiu" and s.samples.ndim == 1]
    if not signals:
        return Table.of([])
    base = max(signals, key=lambda s: len(s.timestamps)).timestamps
    return Table.of([("time", "s", base), *((s.name, s.unit, s.interp(base).samples) for s in signals)])


FORMAT = Format("MDF4", (".mf4",), read, needs="asammdf")
