"""The gap as one HTML report: verdict, where the base deviates from the data, before and after, and the modes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from motofmi.reports.figures import COLOURS
from motofmi.reports.gap_summary import headline, laws, nearest
from motofmi.reports.gap_tables import RUNS, before_and_after, places, verdict_section
from motofmi.reports.report import Report, Section, Table

FILE = "report.html"
PASSING = "Cells in which the misfit passes a false-discovery rate of {:.0%} (Benjamini and Hochberg)."


@dataclass(frozen=True)
class Pictures:
    """Figures with their captions: where the base deviates from the runs, and one run before and after.

    `shown` is a sentence that names that run.
    """

    misses: Sequence[tuple[Figure, str]]
    before_and_after: Sequence[tuple[Figure, str]]
    shown: str = ""


def gap_report(title: str, contents: dict[str, Any], pictures: Pictures, modes: Section | None = None,
               place: str = "axis", fitted: Sequence[Table] = ()) -> Report:  # fmt: skip
    """The report of a verdict's contents; place is the heading of the second column in the table of where the
    base deviates."""
    first, later = list(pictures.before_and_after[:1]), pictures.before_and_after[1:]
    sections = [
        verdict_section(contents, *fitted),
        Section(
            "Where the base model misses the data",
            [PASSING.format(contents["criteria"]["false_discovery_rate"])],
            pictures.misses,
            [places(contents, place)],
        ),
        Section(
            "Before and after",
            [pictures.shown] if pictures.shown else [],
            later,
            [before_and_after(contents)],
        ),
    ]
    sections += [] if modes is None else [modes]
    return Report(title, headline(contents), sections, laws(contents) or nearest(contents), first)


def draw_before_and_after(axes: Any, contents: dict[str, Any]) -> Any:
    """Reduced chi-square before and after as bars on matplotlib axes, for fitted and for validation runs; the axes."""
    shown = [(label, contents["gap"][key]) for key, label in RUNS.items() if contents["gap"][key] is not None][::-1]
    colours = [COLOURS["reference"] if label.endswith("before") else COLOURS["rider"] for label, _ in shown]
    axes.barh([label for label, _ in shown], [value for _, value in shown], color=colours)
    axes.axvline(1, color="#c00000", linewidth=1)
    axes.set(xscale="log", xlabel="reduced chi-square [1]; the line is the noise floor", ylabel="runs [-]")
    return axes
