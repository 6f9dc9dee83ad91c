"""The gap as one HTML report: verdict, where the base deviates from the data, before and after, and the modes."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motofmi.reports.charts import Axis, Chart, Curve, Line, Panel
from motofmi.reports.figures import COLOURS
from motofmi.reports.gap_summary import answer, laws, nearest
from motofmi.reports.gap_tables import RUNS, before_and_after, places, statistics_section, verdict_section
from motofmi.reports.report import Link, Report, Section, Table

FILE = "report.html"
PASSING = "Cells in which the misfit passes a false-discovery rate of {:.0%} (Benjamini and Hochberg)."


@dataclass(frozen=True)
class Pictures:
    """Figures with their captions: where the base deviates from the runs, and one run before and after.

    `shown` is a sentence that names that run.
    """

    misses: Sequence[tuple[Chart, str]]
    before_and_after: Sequence[tuple[Chart, str]]
    shown: str = ""


def gap_report(
    title: str,
    contents: dict[str, Any],
    pictures: Pictures,
    modes: Section | None = None,
    place: str = "axis",
    fitted: Sequence[Table] = (),
    inputs: Sequence[Path] = (),
    files: Sequence[Link] = (),
) -> Report:
    """The report of a verdict's contents; place is the heading of the second column in the table of where the
    base deviates. inputs are the recordings, files what was written beside the report."""
    first, later = list(pictures.before_and_after[:1]), pictures.before_and_after[1:]
    where = places(contents, place)
    sections = [
        verdict_section(contents, *fitted),
        Section(
            "Before and after",
            [pictures.shown] if pictures.shown else [],
            [(before_and_after_chart(contents), "Reduced chi-square before and after."), *later],
            [before_and_after(contents)],
        ),
        *([] if modes is None else [modes]),
        Section(
            "Where the base model misses the data",
            [PASSING.format(contents["criteria"]["false_discovery_rate"]) if where.rows else "Nowhere significantly."],
            pictures.misses,
        ),
        statistics_section(contents),
        *([Section("All places where the base deviates", [], [], [where], folded=True)] if where.rows else []),
    ]
    return Report(
        title,
        answer(contents),
        sections,
        [*laws(contents), *nearest(contents)],
        first,
        asked="Does the model explain the recordings, and if not, which physical effect is missing?",
        inputs=inputs,
        files=files,
    )


def before_and_after_chart(contents: dict[str, Any]) -> Chart:
    """Reduced chi-square before and after as bars, for fitted and for validation runs."""
    shown = [(label, contents["gap"][key]) for key, label in RUNS.items() if contents["gap"][key] is not None]
    names = [label for label, _ in shown]
    bars = [Curve(word, [v for _, v in kept], [names.index(label) for label, _ in kept], colour, "bars")
            for word, colour in (("before", "measured"), ("after", "found"))
            if (kept := [(label, v) for label, v in shown if label.endswith(word)])]  # fmt: skip
    low, high = _decades([value for _, value in shown])
    return Chart(
        [
            Panel(
                Axis("reduced chi-square", "1", log=True, low=low, high=high),
                Axis("runs", "", names=names),
                bars,
                lines=[Line(1.0, "noise floor", across="x")],
                hover="point",
                height=70 + 45 * len(shown),
            )
        ]
    )


def _decades(values: Sequence[float]) -> tuple[float, float]:
    """The powers of ten that enclose the values and the noise floor."""
    inside = [*values, 1.0]
    return float(10 ** np.floor(np.log10(0.8 * min(inside)))), float(10 ** np.ceil(np.log10(max(inside))))


def draw_before_and_after(axes: Any, contents: dict[str, Any]) -> Any:
    """Reduced chi-square before and after as bars on matplotlib axes, for fitted and for validation runs; the axes."""
    shown = [(label, contents["gap"][key]) for key, label in RUNS.items() if contents["gap"][key] is not None][::-1]
    colours = [COLOURS["reference"] if label.endswith("before") else COLOURS["rider"] for label, _ in shown]
    axes.barh([label for label, _ in shown], [value for _, value in shown], color=colours)
    axes.axvline(1, color="#c00000", linewidth=1)
    axes.set(
        xscale="log",
        xlabel="reduced chi-square [1]",
        ylabel="runs [-]",
        xlim=_decades([value for _, value in shown]),
    )
    axes.text(1, 1.02, "noise floor", transform=axes.get_xaxis_transform(), color="#c00000", ha="center")
    return axes
