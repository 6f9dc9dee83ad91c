"""The figure of a planned experiment: the magnitude from which each effect would be named."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from motofmi.reports.charts import Axis, Chart, Curve, Panel
from motofmi.reports.figures import COLOURS, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plan_figure(effects: Sequence[Mapping[str, Any]]) -> Figure:
    """The effects of a plan, one bar each."""
    figure, axes = new_figure(width=8, height=0.24 * len(effects) + 1.2)
    draw_plan(axes, effects)
    return figure


def plan_chart(effects: Sequence[Mapping[str, Any]]) -> Chart:
    """The same bars as a chart; effects that are never named have none."""
    ratios = {
        place: e["named_from"] / e["noticed_from"]
        for place, e in enumerate(effects)
        if e["named_from"] and e["noticed_from"]
    }
    bars = Curve("magnitude to be named", list(ratios.values()), list(ratios), "found", "bars")
    axis = Axis("magnitude to be named over magnitude to be detected", "1", log=True, low=1.0)
    return Chart([Panel(axis, Axis("", "", names=_labels(effects)), [bars], height=18 * len(effects) + 60)])


def _labels(effects: Sequence[Mapping[str, Any]]) -> list[str]:
    return [f"{e['name'].replace('_', ' ')} ({e['form'].replace('_', ' ')})" for e in effects]


def draw_plan(axes: Any, effects: Sequence[Mapping[str, Any]]) -> Any:
    """Plot for each effect the ratio of the magnitude to be named to the magnitude to be detected.

    An effect that is never named is labelled so. Returns the matplotlib axes.
    """
    labels = _labels(effects)
    for place, e in enumerate(effects):
        if e["named_from"] and e["noticed_from"]:
            axes.barh(place, e["named_from"] / e["noticed_from"] - 1, left=1, color=COLOURS["rider"])
        else:
            reason = f"tied with {', '.join(e['tied'])}" if e["tied"] else "absorbed by parameters of the base"
            axes.text(1.03, place, reason.replace("_", " "), va="center", fontsize=7, color=COLOURS["reference"])
    axes.set_yticks(range(len(labels)), labels)
    axes.set(
        xscale="log", ylim=(len(labels) - 0.4, -0.6), xlabel="magnitude to be named\nover magnitude to be detected [1]"
    )
    axes.set_xlim(left=1)
    return axes
