"""Charts as figures of matplotlib: for pictures in documents, and for `.plot()`."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import FixedLocator

from motofmi.reports.charts import COLOURS, Axis, Cells, Chart, Curve, Panel, placed

STYLES = {"line": "-", "dashed": "--", "dotted": ":", "points": ".", "both": ".-"}
DOTS_PER_INCH, WIDTH = 100, 8.0  # px of a panel's height per inch; in, of a figure


def figure(chart: Chart, width: float = WIDTH) -> Figure:
    """The chart with the curves that it shows at first."""
    rows = -(-len(chart.panels) // chart.columns)
    heights = [max(p.height for p in chart.panels[k * chart.columns : (k + 1) * chart.columns]) for k in range(rows)]
    picture = Figure(figsize=(width, sum(heights) / DOTS_PER_INCH + 0.3), layout="constrained")
    axes = picture.subplots(rows, chart.columns, squeeze=False, height_ratios=heights).flat
    for panel, on in zip(chart.panels, axes, strict=False):
        draw(panel, on)
    for unused in list(axes)[len(chart.panels) :]:
        unused.remove()
    return picture


def draw(panel: Panel, on: Any) -> Any:
    """A panel on axes of matplotlib, which are returned."""
    on.grid(True, color="#dddddd", linewidth=0.6)
    on.set_axisbelow(True)
    for shade in panel.shades:
        span = on.axvspan if shade.across == "x" else on.axhspan
        span(shade.low, shade.high, color=COLOURS[shade.colour][0], alpha=shade.opacity, linewidth=0, zorder=0)
    for line in panel.lines:
        (on.axvline if line.across == "x" else on.axhline)(line.at, color="black", linestyle="--", linewidth=0.8)
    if panel.cells is not None:
        _cells(panel.cells, on)
    for curve in panel.curves:
        if curve.shown:
            _curve(curve, on)
    _axes(panel, on)
    for note in placed(panel):
        on.text(note.x, note.y, note.text, color=COLOURS[note.colour][0], fontsize=8, ha="center", va="center")
    if len({c.name for c in panel.curves if c.shown}) > 1 and panel.curves[0].style != "bars":
        on.legend(handles=_handles(panel.curves), fontsize=8)
    return on


def _curve(curve: Curve, on: Any) -> None:
    colour, x, y = COLOURS[curve.colour][0], np.asarray(curve.x, float), np.asarray(curve.y, float)
    if curve.style == "errors":
        on.errorbar(
            x,
            y,
            [y - np.asarray(curve.band[0]), np.asarray(curve.band[1]) - y],  # type: ignore[index]
            fmt=".",
            color=colour,
        )
        return
    if curve.band is not None:
        on.fill_between(x, *(np.asarray(side, float) for side in curve.band), color=colour, alpha=0.2, linewidth=0)
    if curve.style == "bars":
        on.barh(y, x, color=colour)
    elif curve.style == "needles":
        for tip in zip(x, y, strict=True):
            on.annotate("", tip, (0, 0), arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.6})
    elif curve.style == "circles":
        on.scatter(
            x,
            y,
            s=16 if curve.size is None else np.asarray(curve.size, float) ** 2 / 2,
            facecolors="none",
            edgecolors=colour,
            linewidths=0.8,
        )
    else:
        on.plot(x, y, STYLES[curve.style], color=colour, linewidth=0.8 * curve.width, markersize=4)


def _handles(curves: Sequence[Curve]) -> list[Patch]:
    return [
        Patch(color=COLOURS[colour][0], label=name)
        for name, colour in {c.name: c.colour for c in curves if c.shown}.items()
    ]


def _cells(cells: Cells, on: Any) -> None:
    norm = LogNorm(cells.low, cells.high)
    framed = np.zeros(np.shape(cells.x), bool) if cells.framed is None else np.asarray(cells.framed, bool)
    rows = zip(
        *(np.asarray(getattr(cells, n), float) for n in ("x", "x_end", "y", "y_end", "value")), framed, strict=True
    )
    from_value = ScalarMappable(norm, "viridis")
    for x, x_end, y, y_end, value, frame in rows:
        edge = COLOURS["significant"][0] if frame else "none"
        on.add_patch(Rectangle((x, y), x_end - x, y_end - y, facecolor=from_value.to_rgba(value), edgecolor=edge))
    on.get_figure().colorbar(from_value, ax=on, label=cells.label)
    on.autoscale_view()


def _axes(panel: Panel, on: Any) -> None:
    for axis, which in ((panel.x, "x"), (panel.y, "y")):
        _axis(axis, which, on)
    if panel.square:
        on.set_aspect("equal", adjustable="datalim")
    on.set_title(panel.title, fontsize=9)


def _axis(axis: Axis, which: str, on: Any) -> None:
    getattr(on, f"set_{which}scale")("log" if axis.log else "linear")
    getattr(on, f"set_{which}lim")(axis.low, axis.high)
    getattr(on, f"set_{which}label")(axis.title)
    if axis.names:
        getattr(on, f"{which}axis").set_major_locator(FixedLocator(range(len(axis.names))))
        getattr(on, f"set_{which}ticklabels")(axis.names)
        getattr(on, f"set_{which}lim")(len(axis.names) - 0.5, -0.5)
