"""A report: sections of text, figures and tables in one HTML file that needs no network."""

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jinja2
from matplotlib.figure import Figure

from fmus.support.files import write_text
from fmus.support.parallel import parallel_map

COLOURS = {"reference": "#888888", "rider": "#0b5394", "damper": "#c55a11", "changed": "#38761d"}


@dataclass(frozen=True)
class Table:
    """Rows under headings; a cell is text. `marks` gives a row's class: met, near, missed."""

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    marks: Sequence[str] = ()


@dataclass(frozen=True)
class Section:
    """One question and its answer: paragraphs, then figures, then tables."""

    title: str
    paragraphs: Sequence[str]
    figures: Sequence[tuple[Figure, str]] = ()
    tables: Sequence[Table] = ()


@dataclass
class Report:
    """Sections under a title. lead, equations and figures are the first screen."""

    title: str
    lead: str
    sections: list[Section] = field(default_factory=list)
    equations: Sequence[str] = ()
    figures: Sequence[tuple[Figure, str]] = ()

    def write(self, path: Path) -> None:
        """Write the report as one HTML file. Raises InputError if it cannot be written."""
        loader = jinja2.FileSystemLoader(Path(__file__).parent)
        environment = jinja2.Environment(loader=loader, autoescape=True, undefined=jinja2.StrictUndefined)
        shown = [*self.figures, *(each for section in self.sections for each in section.figures)]
        figures = [figure for figure, _ in shown]
        drawn = dict(zip(map(id, figures), parallel_map(as_png, figures, "drawing"), strict=True))
        environment.filters["png"] = lambda figure: drawn[id(figure)]
        write_text(path, environment.get_template("report.html").render(report=self))


def as_png(figure: Figure) -> str:
    """The figure as a data URL."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=130, metadata={"Software": None})
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()


def new_figure(
    columns: int = 1, rows: int = 1, width: float = 8.0, height: float = 4.8, **options: Any
) -> tuple[Figure, Any]:
    """A figure and its axes, with a light grid; no state outside it."""
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(rows, columns, **options)
    for ax in [axes] if rows * columns == 1 else axes.flat:
        ax.grid(True, color="#dddddd", linewidth=0.6)
        ax.set_axisbelow(True)
    return figure, axes
