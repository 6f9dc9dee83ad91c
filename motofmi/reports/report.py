"""A report: one HTML file that needs no network. First what was asked, the answer and one picture, then sections."""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from urllib.parse import quote

import jinja2
from markupsafe import Markup

from fmus.support.files import write_text
from fmus.support.plain_json import to_json
from motofmi.reports import provenance
from motofmi.reports.charts import COLOURS, Chart
from motofmi.reports.glossary import Marker, slug
from motofmi.reports.illustration import Illustration

PAGE = Path(__file__).parent / "page"
Shown = Chart | Illustration
Link = tuple[str | Path, str]  # a file, and what it contains


@dataclass(frozen=True)
class Table:
    """Rows under headings; a cell is text. `marks` gives a row's class: met, near, missed. `links` gives the address of
    a row's first cell, or an empty text. With `shades` a number between -1 and 1 is a coloured cell."""

    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    marks: Sequence[str] = ()
    shades: bool = False
    links: Sequence[str] = ()

    def shade(self, cell: str) -> str:
        """The style of a coloured cell."""
        try:
            value = float(cell) if self.shades else 0.0
        except ValueError:
            return ""
        return (
            f"background: rgb({'200 90 20' if value < 0 else '30 110 190'} / {0.5 * min(abs(value), 1):.2f})"
            if value
            else ""
        )

    @property
    def numbers(self) -> list[bool]:
        """Which columns hold numbers only: they are aligned to the right."""
        return [
            bool(self.rows) and all(re.fullmatch(r"(<\s*)?[-+]?\d[\d.]*(e[-+]?\d+)?%?|", row[k]) for row in self.rows)
            for k in range(len(self.headings))
        ]


@dataclass(frozen=True)
class Section:
    """One question and its answer: paragraphs, then figures, then tables. A folded one is closed at first.
    files are linked below."""

    title: str
    paragraphs: Sequence[str]
    figures: Sequence[tuple[Shown, str]] = ()
    tables: Sequence[Table] = ()
    folded: bool = False
    files: Sequence[Link] = ()


@dataclass
class Report:
    """Sections under a title. asked, lead (the answer), equations, warnings and figures are the first screen.

    inputs are the files that the results come from, files those that were written with the report.
    """

    title: str
    lead: str
    sections: list[Section] = field(default_factory=list)
    equations: Sequence[str] = ()
    figures: Sequence[tuple[Shown, str]] = ()
    asked: str = ""
    warnings: Sequence[str] = ()
    inputs: Sequence[str | Path] = ()
    files: Sequence[Link] = ()

    def write(self, path: Path) -> None:
        """Write the report as one HTML file. Raises InputError if it cannot be written."""
        write_text(path, self.html(path.absolute().parent))

    def html(self, folder: Path | None = None) -> str:
        """The page; links to files are relative to its folder."""
        marker = Marker()
        environment = jinja2.Environment(loader=jinja2.FileSystemLoader(PAGE), autoescape=True, trim_blocks=True,
                                         undefined=jinja2.StrictUndefined)  # fmt: skip
        beside = folder or Path.cwd()
        environment.filters |= {
            "drawn": drawn,
            "terms": marker.marked,
            "slug": slug,
            "links": lambda files: links(files, beside),
        }
        shown = [figure for figure, _ in (*self.figures, *(f for section in self.sections for f in section.figures))]
        return environment.get_template("report.html").render(
            report=self, made=provenance.made(self.inputs), files=provenance.also_written(self.files),
            style=Markup(style()), scripts=[Markup(text) for text in scripts(shown)], begin=marker.begin,
            explained=marker.explained, uses_charts=any(isinstance(f, Chart) for f in shown),
        )  # fmt: skip


def chart_page(chart: Chart, title: str) -> str:
    """A page with one chart and nothing else."""
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, '
        f'initial-scale=1"><title>{Markup.escape(title)}</title><link rel="icon" href="data:,">'
        f"<style>{style()}</style></head><body>"
        f'<main><h1 class="unseen">{Markup.escape(title)}</h1>',
        drawn(chart, title),
        "</main>",
        *(f"<script>{text}</script>" for text in scripts([chart])),
        "</body></html>",
    ]
    return "\n".join(parts)


def style() -> str:
    """The style sheet of a page, with the colours of curves as variables."""
    light, dark = ("".join(f"--c-{name}: {pair[k]}; " for name, pair in COLOURS.items()) for k in (0, 1))
    return (
        f":root {{ {light}}} @media (prefers-color-scheme: dark) {{ :root {{ {dark}}} }} @media print "
        f"{{ :root {{ {light}}} }}\n" + _page("report.css")
    )


def scripts(shown: Sequence[Shown]) -> list[str]:
    """The scripts that a page with these figures needs."""
    found = []
    if any(isinstance(figure, Chart) for figure in shown):
        found += [chart_library(), _page("charts.js")]
    for name in dict.fromkeys(f.script for f in shown if isinstance(f, Illustration) and f.script):
        found.append(_page(name))
    return [*found, _page("page.js")]


def chart_library() -> str:
    """Apache ECharts with its notice, as page/vendor/README.md says."""
    return "/* Apache ECharts, Apache License 2.0, https://echarts.apache.org */" + _page("vendor/echarts.min.js")


def drawn(shown: Shown, caption: str) -> Markup:
    """The HTML of a chart, which `page/charts.js` fills, or of an illustration."""
    if isinstance(shown, Illustration):
        return Markup(shown.markup)
    data = to_json(shown.to_dict(), indent=None).replace("</", "<\\/")
    words = Markup.escape(shown.words or f"{caption} {shown.described()}")
    return Markup(f'<div class="chart" role="group" aria-label="{words}"></div>'
                  f'<script type="application/json">{data}</script>')  # fmt: skip


def links(files: Sequence[Link], folder: Path) -> list[tuple[str, str]]:
    """The address of each file relative to a page's folder, and the words that name it."""
    found = []
    for path, text in files:
        relative = Path(os.path.relpath(Path(path).absolute(), folder)).as_posix()
        found.append((quote(relative), f"{relative}: {text}" if text else relative))
    return found


@cache
def _page(name: str) -> str:
    return (PAGE / name).read_text("utf-8")
