"""The main tasks in sequence, with one report."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter
from typing import Any

from fmus.support.files import writable
from fmus.support.notebook import html
from motofmi.reports.charts import Chart
from motofmi.reports.report import Link, Report, Section, Table
from motofmi.workflows.scenarios import Answered, answered

FILE = "report.html"
ASKED = (
    "What do a rider and a steering damper do to the modes of a motorcycle, and can an effect that a model misses be "
    "found in "
    "recordings?"
)
WORDS = (
    "The reference is the motorcycle of Cossalter, Doria, Lot, Massaro, Meccanica 46 (2011), without a rider's "
    "impedance; the mean "
    "rider has the mean of their ten measured riders. Every number was computed by this run."
)


@dataclass(frozen=True, repr=False)
class Tour:
    """The steps of a tour, each with name, seconds and answer, and the path of the report; `tour` shows an example."""

    steps: Sequence[Mapping[str, Any]]
    report: Path

    def to_dict(self) -> dict[str, Any]:
        """The keys of `motofmi tour --json`; `report` is relative to `out`."""
        return {"steps": list(self.steps), "report": self.report.name, "out": str(self.report.parent)}

    def __repr__(self) -> str:
        return f"Tour({len(self.steps)} steps in {sum(s['seconds'] for s in self.steps):.0f} s; {self.report})"

    def _repr_html_(self) -> str:
        return html(
            f"The report is {self.report}.",
            ("step", "time [s]", "answer"),
            [(s["name"], f"{s['seconds']:.1f}", s["answer"]) for s in self.steps],
        )


def tour_report(found: Sequence[Answered]) -> Report:
    """The answers of the tour's scenarios, with what the first that gives a chart says on the first screen."""
    sections = [each.section for each in found]
    first = next(section for section in sections if any(isinstance(figure, Chart) for figure, _ in section.figures))
    return report_of_questions("motofmi: the tour", ASKED, WORDS, sections, first)


def report_of_questions(
    title: str, asked: str, words: str, sections: Sequence[Section], first: Section, files: Sequence[Link] = ()
) -> Report:
    """A report whose first screen has the first paragraph and the first figure of one of its sections; then a table of
    all answers, under words, and the sections."""
    table = Table(("question", "answer"), [(section.title, section.paragraphs[0]) for section in sections])
    without = replace(first, paragraphs=first.paragraphs[1:], figures=first.figures[1:])
    return Report(
        title,
        first.paragraphs[0],
        [
            Section("All answers", [words], [], [table]),
            *(without if section is first else section for section in sections),
        ],
        figures=first.figures[:1],
        asked=asked,
        files=files,
    )


def tour(out: str | Path = "tour", *, seed: int = 1) -> Tour:
    """Build FMUs, co-simulate them, compare modes with the published ones, find a hidden effect, and write
    one report into `out`.

    seed draws the rider and the hidden effect of the virtual rig. Raises InputError where the folder cannot be written.

        >>> found = mf.tour("tour")
        >>> found.report.name, len(found.steps) == len(found.to_dict()["steps"])
        ('report.html', True)
    """
    path = writable(Path(out) / FILE)
    found = list(answered("tour", out=path.parent, seed=seed))
    steps: list[Mapping[str, Any]] = [
        {"name": each.step, "seconds": each.seconds, "answer": each.section.paragraphs[0]} for each in found
    ]
    report = tour_report(found)
    start = perf_counter()
    report.write(path)
    steps.append({"name": "report", "seconds": perf_counter() - start, "answer": f"{path}"})
    return Tour(steps, path)
