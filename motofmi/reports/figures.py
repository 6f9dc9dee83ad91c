"""Figures of matplotlib without pyplot: empty axes with a light grid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = {"reference": "#888888", "rider": "#0b5394", "damper": "#c55a11", "changed": "#38761d"}


def new_figure(
    columns: int = 1, rows: int = 1, width: float = 8.0, height: float = 4.8, **options: Any
) -> tuple[Figure, Any]:
    """A figure and its axes, with a light grid; no state outside it."""
    from matplotlib.figure import Figure  # noqa: PLC0415 - imported on use: it takes 0.3 s

    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(rows, columns, **options)
    for ax in [axes] if rows * columns == 1 else axes.flat:
        ax.grid(True, color="#dddddd", linewidth=0.6)
        ax.set_axisbelow(True)
    return figure, axes
