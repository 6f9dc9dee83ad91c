"""Where the base misses the data: places that pass the false-discovery rate, over recording, response and orders."""

import numpy as np
from matplotlib.figure import Figure

from identification.gap.data.runs import Run
from identification.gap.naming.fitting import Fit
from identification.gap.reporting.locating import Place
from scenarios.report import COLOURS, new_figure

MISS = "#c00000"


def gap_map(found: Fit, places: list[Place], unit: str, index: int = 0) -> Figure:
    """A run's measured output over time, its response over frequency, and all residuals over time and order.

    unit is the output's. What is red is a place where the misfit is no chance; the redder, the larger its excess.
    """
    run: Run = found.runs[index]
    start = sum(len(r.data) for r in found.runs[:index])
    z = found.residuals[start : start + len(run.data)]
    mine = [p for p in places if p.run == run.name]
    picture, (over_time, over_frequency, orders) = new_figure(rows=3, height=8.5)
    over_time.plot(run.recording.time, run.measured, color=COLOURS["reference"], linewidth=0.4)
    over_time.set(xlabel=f"time in {run.name} [s]", ylabel=f"measured output [{unit}]")
    _shade(over_time, mine, "time")
    frequency, size = _response(run)
    over_frequency.semilogy(frequency, size, ".-", color=COLOURS["rider"])
    over_frequency.set(xlabel="frequency [Hz]", ylabel=f"first harmonic, output\nover motion [{unit}/{run.unit}]")
    _shade(over_frequency, mine, "frequency")
    columns = run.reduction.columns
    cells: dict[tuple[float, int], list[float]] = {}
    for column, miss in zip(columns, z, strict=True):
        cells.setdefault((column.time, column.order), []).append(miss**2)
    misses = np.clip([np.sqrt(np.mean(squares)) for squares in cells.values()], 0, 6)
    points = orders.scatter(*zip(*cells, strict=True), c=misses, s=24, marker="s", cmap="viridis")
    picture.colorbar(points, ax=orders, label="residual over noise (rms)")
    orders.set(xlabel=f"time in {run.name} [s]", ylabel="order")
    for place in mine:
        if place.axis == "order":
            orders.axhspan(place.start - 0.4, place.end + 0.4, color=MISS, alpha=0.15)
    return picture


def _shade(axes, places: list[Place], axis: str) -> None:
    for place in places:
        if place.axis == axis:
            axes.axvspan(place.start, place.end, color=MISS, alpha=float(np.clip(0.1 + 0.15 * np.log10(1 + max(place.excess, 0.0)), 0.1, 0.5)))


def _response(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Frequency (w,) and the first harmonic of the output over that of the motion (w,), by window."""
    columns = run.reduction.columns
    pairs = np.array([i for i, c in enumerate(columns) if c.order == 1 and c.degree == 0]).reshape(-1, 2)
    motion = run.reduction.reduce(run.moved(run.recording.time)[0])
    size = np.hypot(*run.data[pairs.T]) / np.hypot(*motion[pairs.T])
    frequency = np.array([columns[i].frequency for i in pairs[:, 0]])
    order = np.argsort(frequency)
    return frequency[order], size[order]
