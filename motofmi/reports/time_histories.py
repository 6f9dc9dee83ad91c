"""Signals of a co-simulation over time as a chart, a panel for each unit; angles in degrees."""

from collections.abc import Sequence

import numpy as np

from fmus.cosimulation.cosimulation_run import TIME, CosimulationRun
from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel


def time_histories(run: CosimulationRun, names: Sequence[str] = ()) -> Chart:
    """The signals of these names, by default all of them, over time."""
    units, table = run.units, run.table()
    columns = list(units)
    by_unit: dict[str, list[str]] = {}
    for name in names or [n for n in columns if n != TIME]:
        by_unit.setdefault(units[name], []).append(name)
    panels = []
    for unit, group in by_unit.items():
        angle = unit.startswith("rad")
        shown, factor = (unit.replace("rad", "deg"), 180 / np.pi) if angle else (unit, 1.0)
        curves = [
            Curve(
                name.replace("_", " "),
                table[:, 0],
                factor * np.asarray(table[:, columns.index(name)]),
                SEQUENCE[k % len(SEQUENCE)],
            )
            for k, name in enumerate(group)
        ]
        label = group[0].rpartition(".")[2].replace("_", " ") if len(group) == 1 else "signals"
        panels.append(Panel(Axis("time", "s"), Axis(label, shown), curves, height=240))
    return Chart(panels, linked=True)
