"""A chart by itself: interactive in a notebook, or a page of its own."""

from html import escape
from pathlib import Path

from fmus.support.files import write_text
from motofmi.reports.charts import Chart
from motofmi.reports.report import chart_page

FRAME = ("<iframe srcdoc=\"{}\" style=\"width:100%;height:{}px;border:0\" sandbox=\"allow-scripts\" "
         "title=\"{}\"></iframe>")  # fmt: skip
BESIDE = 90  # px, of legend and margins


class Interactive:
    """A chart that a notebook displays with zoom, values at the pointer and curves that switch; `save` writes a page.

    Each display contains the library that draws it (0.6 MB), so that a saved notebook needs no network.
    """

    def __init__(self, chart: Chart, title: str = "motofmi") -> None:
        self.chart, self.title = chart, title

    def to_dict(self) -> dict:
        """The chart as data."""
        return self.chart.to_dict()

    def save(self, path: str | Path) -> Path:
        """Write the chart as one HTML file, which needs no network; its path. Raises InputError where it cannot be
        written."""
        write_text(Path(path), chart_page(self.chart, self.title))
        return Path(path)

    def __repr__(self) -> str:
        return f"Interactive({self.chart.described()}; displayed in a notebook, or save('chart.html'))"

    def _repr_html_(self) -> str:
        height = BESIDE + sum(panel.height for panel in self.chart.panels) // self.chart.columns
        return FRAME.format(escape(chart_page(self.chart, self.title)), height, escape(self.title))
