"""Universal files (data set 58), as modal analysis programs write them."""

from pathlib import Path

import numpy as np

from motofmi.recordings.table import Format, Table


def read(path: Path) -> Table:
    """The time responses: the name from id1, the unit from the ordinate's label."""
    import pyuff  # noqa: PLC0415 - an optional package

    sets = pyuff.UFF(str(path)).read_sets()
    found: dict[str, tuple[str, np.ndarray]] = {}
    for data in [sets] if isinstance(sets, dict) else sets:
        if data.get("type") == 58 and data.get("func_type") == 1:
            found.setdefault("time", ("s", data["x"]))
            found[data["id1"].strip()] = (data.get("ordinate_axis_units_lab", "").strip(), data["data"])
    return Table.of((name, unit, values) for name, (unit, values) in found.items())


FORMAT = Format("universal", (".uff", ".unv"), read, needs="pyuff")
