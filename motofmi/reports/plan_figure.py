"""The figure of a planned experiment: how strong each effect must be to be named."""

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from motofmi.reports.report import COLOURS, new_figure


def plan_figure(effects: Sequence[Mapping[str, Any]]) -> Figure:
    """The effects of a plan, one bar each."""
    figure, axes = new_figure(width=8, height=0.24 * len(effects) + 1.2)
    draw_plan(axes, effects)
    return figure


def draw_plan(axes: Any, effects: Sequence[Mapping[str, Any]]) -> Any:
    """Strength to be named over strength to be noticed, on matplotlib axes; a word where an effect is
    never named. The axes."""
    labels = [f"{e['name'].replace('_', ' ')} ({e['form'].replace('_', ' ')})" for e in effects]
    for place, e in enumerate(effects):
        if e["named_from"] and e["noticed_from"]:
            axes.barh(place, e["named_from"] / e["noticed_from"] - 1, left=1, color=COLOURS["rider"])
        else:
            reason = f"tied with {', '.join(e['tied'])}" if e["tied"] else "the base makes up for it"
            axes.text(1.03, place, reason.replace("_", " "), va="center", fontsize=7, color=COLOURS["reference"])
    axes.set_yticks(range(len(labels)), labels)
    axes.set(
        xscale="log", ylim=(len(labels) - 0.4, -0.6), xlabel="strength to be named\nover strength to be noticed [1]"
    )
    axes.set_xlim(left=1)
    return axes
