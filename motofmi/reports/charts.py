"""Charts as data: panels with axes, curves, shaded ranges and cells, independent of what draws them.

`Chart.to_dict()` is what a page draws interactively (`page/charts.js`); `chart_figures.figure` draws the same with
matplotlib. Angles on charts are in degrees, everything else in SI.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

DIGITS = 5  # significant, of a coordinate
POINTS = (
    3000  # of a curve; a longer one is drawn by the smallest and the largest value in each of half as many intervals
)

# The colours of curves by meaning, on a light and on a dark background (Okabe, Ito 2008, and Tol 2021 for the last).
COLOURS = {
    "measured": ("#6b6b6b", "#b0b0b0"), "base": ("#b34700", "#ff9d5c"), "found": ("#0b5394", "#6db3f2"),
    "changed": ("#2c7a1f", "#7fd06f"), "fourth": ("#8e3a8e", "#d692d6"), "fifth": ("#7a6000", "#d9bf4d"),
    "sixth": ("#006d77", "#5fc9d3"), "significant": ("#c00000", "#ff7b72"),
}  # fmt: skip
SEQUENCE = (
    "found",
    "base",
    "changed",
    "fourth",
    "fifth",
    "sixth",
    "measured",
)  # for curves without a meaning of their own


@dataclass(frozen=True)
class Axis:
    """What an axis shows, in which unit ("1" where it has none); low and high limit it, names replace its numbers."""

    label: str
    unit: str
    log: bool = False
    low: float | None = None
    high: float | None = None
    names: Sequence[str] = ()

    @property
    def title(self) -> str:
        return f"{self.label} [{self.unit}]" if self.unit else self.label


@dataclass(frozen=True)
class Curve:
    """x, y (n,) under a name; curves with the same name are one entry of the legend.

    style is `line`, `dashed`, `dotted`, `points`, `circles`, `both` (points on a line), `bars` (horizontal, from the
    axis's lower end), `needles` (from the origin), or `errors` (points with
    the band as bars). band is the lower and upper limit (n,) of y. text (n,) is shown
    where the pointer is. `shown` is whether the curve is visible at first. Raises ValueError for x and y of different
    shape.
    """

    name: str
    x: ArrayLike
    y: ArrayLike
    colour: str = "measured"
    style: str = "line"
    band: tuple[ArrayLike, ArrayLike] | None = None
    text: Sequence[str] = ()
    shown: bool = True
    width: float = 1.6
    size: ArrayLike | None = None  # of points [px], one or (n,)

    def __post_init__(self) -> None:
        if np.shape(self.x) != np.shape(self.y):
            raise ValueError(f"{self.name}: x {np.shape(self.x)} and y {np.shape(self.y)} differ in shape")


@dataclass(frozen=True)
class Shade:
    """A shaded range of the x axis (`across` "x") or of the y axis, with its meaning."""

    low: float
    high: float
    label: str = ""
    across: str = "x"
    colour: str = "significant"
    opacity: float = 0.14


@dataclass(frozen=True)
class Line:
    """A thin line across the panel at x or y, with its meaning."""

    at: float
    label: str = ""
    across: str = "y"


@dataclass(frozen=True)
class Cells:
    """Rectangles (n,) from x to x_end and y to y_end, coloured by value on a logarithmic scale from low to high.

    framed (n,) are drawn with a frame.
    """

    x: ArrayLike
    x_end: ArrayLike
    y: ArrayLike
    y_end: ArrayLike
    value: ArrayLike
    label: str
    low: float
    high: float
    framed: ArrayLike | None = None


@dataclass(frozen=True)
class Note:
    """A few words at a point; `Panel` moves them to where nothing is drawn."""

    x: float
    y: float
    text: str
    colour: str = "measured"


@dataclass(frozen=True)
class Panel:
    """Two axes with what is drawn on them. `hover` is `x` (all curves at one x) or `point`."""

    x: Axis
    y: Axis
    curves: Sequence[Curve] = ()
    title: str = ""
    shades: Sequence[Shade] = ()
    lines: Sequence[Line] = ()
    cells: Cells | None = None
    notes: Sequence[Note] = ()
    hover: str = "x"
    square: bool = False  # equal scales of both axes
    height: int = 300  # px

    def to_dict(self) -> dict[str, Any]:
        return {
            "title": self.title, "hover": self.hover, "square": self.square, "height": self.height,
            "x": _axis(self.x), "y": _axis(self.y), "curves": [_curve(curve) for curve in self.curves],
            "shades": [vars(shade) for shade in self.shades], "lines": [vars(line) for line in self.lines],
            "cells": None if self.cells is None else _cells(self.cells),
            "notes": [vars(note) for note in placed(self)],
        }  # fmt: skip


@dataclass(frozen=True)
class Chart:
    """Panels with one legend, `columns` of them side by side where the page is wide enough.

    linked panels zoom and show the pointer together. `words` describe the chart to those who do not see it.
    """

    panels: Sequence[Panel]
    columns: int = 1
    linked: bool = False
    words: str = ""
    choices: Sequence["Choice"] = field(default=())

    def to_dict(self) -> dict[str, Any]:
        """What `page/charts.js` draws."""
        return {"panels": [panel.to_dict() for panel in self.panels], "columns": self.columns, "linked": self.linked,
                "words": self.words or self.described(), "choices": [vars(choice) for choice in self.choices],
                "colours": COLOURS}  # fmt: skip

    def described(self) -> str:
        """The axes and the curves in a sentence."""
        return ". ".join(
            f"{panel.y.title} over {panel.x.title}: {', '.join(dict.fromkeys(c.name for c in panel.curves))}"
            for panel in self.panels
        )


@dataclass(frozen=True)
class Choice:
    """A button over the chart that shows these curves and hides the others."""

    label: str
    curves: Sequence[str]


def rounded(values: ArrayLike) -> list[float | None]:
    """The numbers with DIGITS significant digits; None for what is not finite."""
    return [float(f"{v:.{DIGITS}g}") if np.isfinite(v) else None for v in np.asarray(values, float).tolist()]


def thinned(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The places (m,) of a long curve that keep its outline: the smallest and the largest value in each interval, and
    those that are not finite, where it is interrupted."""
    if len(x) <= POINTS:
        return np.arange(len(x))
    edges, finite = np.linspace(0, len(x), POINTS // 2 + 1).astype(int), np.nan_to_num(y)
    places = [k for a, b in pairwise(edges) for k in (a + np.argmin(finite[a:b]), a + np.argmax(finite[a:b]))]
    return np.unique([0, *places, *np.flatnonzero(~np.isfinite(y)), len(x) - 1])


def _axis(axis: Axis) -> dict[str, Any]:
    return {"title": axis.title, "unit": axis.unit, "label": axis.label, "log": axis.log, "low": axis.low,
            "high": axis.high, "names": list(axis.names)}  # fmt: skip


def _curve(curve: Curve) -> dict[str, Any]:
    x, y = np.asarray(curve.x, float), np.asarray(curve.y, float)
    kept = thinned(x, y) if curve.style in ("line", "dashed", "dotted") else np.arange(len(x))
    found = {"name": curve.name, "x": rounded(x[kept]), "y": rounded(y[kept]), "colour": curve.colour,
             "style": curve.style, "shown": curve.shown, "width": curve.width}  # fmt: skip
    if curve.band is not None:
        found["band"] = [rounded(np.asarray(side, float)[kept]) for side in curve.band]
    if len(curve.text):
        found["text"] = [curve.text[k] for k in kept.tolist()]
    if curve.size is not None:
        found["size"] = rounded(np.broadcast_to(np.asarray(curve.size, float), x.shape)[kept])
    return found


def _cells(cells: Cells) -> dict[str, Any]:
    found = {name: rounded(getattr(cells, name)) for name in ("x", "x_end", "y", "y_end", "value")}
    framed = np.zeros(len(found["x"]), bool) if cells.framed is None else np.asarray(cells.framed, bool)
    return {**found, "label": cells.label, "low": cells.low, "high": cells.high, "framed": framed.tolist()}


LETTER, LINE_HEIGHT = 0.022, 0.05  # of a panel's width and height, that a letter and a line of a note take on a phone


def placed(panel: Panel) -> list[Note]:
    """The notes of a panel beside their points: of several places around each the one that is farthest from curves
    and other notes."""
    horizontal, vertical = _unit_scale(panel, "x"), _unit_scale(panel, "y")
    if not panel.notes or horizontal is None or vertical is None:
        return list(panel.notes)
    drawn = np.concatenate([np.stack([horizontal[0](c.x), vertical[0](c.y)], axis=1) for c in panel.curves if c.shown])
    drawn = drawn[np.isfinite(drawn).all(axis=1)]
    found = []
    for note in panel.notes:
        half = np.array([LETTER * len(note.text) / 2, LINE_HEIGHT / 2])
        at = np.array([horizontal[0](note.x), vertical[0](note.y)])
        turns = np.arange(0, 2 * np.pi, np.pi / 8)
        around = np.concatenate([at + (half + distance) * np.stack([np.cos(turns), np.sin(turns)], axis=1)
                                 for distance in (0.0, 0.02, 0.05, 0.1)])  # fmt: skip
        around = np.clip(around, half, 1 - half)
        free = (np.abs(around[:, None] - drawn) / (half + 0.01)).max(axis=2).min(axis=1).clip(max=1.0)
        best = around[np.argmax(4 * free - np.linalg.norm(around - at, axis=1))]
        drawn = np.concatenate([drawn, best[None]])
        found.append(replace(note, x=float(f"{horizontal[1](best[0]):.4g}"), y=float(f"{vertical[1](best[1]):.4g}")))
    return found


def _unit_scale(panel: Panel, which: str) -> tuple[Any, Any] | None:
    """The functions from an axis to 0 ... 1 within its limits, and back; None where nothing is drawn."""
    axis: Axis = getattr(panel, which)
    change, back = (np.log10, lambda v: 10**v) if axis.log else (lambda v: np.asarray(v, float), lambda v: v)
    values = (
        np.concatenate([change(np.asarray(getattr(c, which), float)) for c in panel.curves])
        if panel.curves
        else np.zeros(0)
    )
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    low = float(values.min()) if axis.low is None else float(change(axis.low))
    width = (float(values.max()) if axis.high is None else float(change(axis.high))) - low or 1.0
    return lambda v: (change(np.asarray(v, float)) - low) / width, lambda u: back(low + width * u)
