"""The questions about the full rider and the rider in roll, answered in one report.

python -m motofmi.scenarios.the_full_rider --out full_rider
"""

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from fmus.support.files import writable, write_atomically
from motofmi.reports.chart_figures import figure
from motofmi.reports.charts import Chart
from motofmi.reports.provenance import Command, command_line
from motofmi.reports.report import Link, Report
from motofmi.workflows.scenarios import Answered, answered
from motofmi.workflows.tour import report_of_questions

ASKED = "What does a rider of six bodies, or one who leans, add to the passive rider of 2011?"
WORDS = ("The six-body rider of 2008 and the rider in roll: where their inertias come from, how far kinematics goes, "
         "what the gap workflow says of them, and what lean does to weave. This run computed every number.")  # fmt: skip


def report(found: Sequence[Answered], files: Sequence[Link] = ()) -> Report:
    """The answers, with what lean does to weave, the last of them, on the first screen."""
    sections = [each.section for each in found]
    return report_of_questions("motofmi: the full rider", ASKED, WORDS, sections, sections[-1], files)


def picture(answer: Answered, folder: Path) -> Link:
    """The first chart of an answer, written as a PNG of its name."""
    chart = next(shown for shown, _ in answer.section.figures if isinstance(shown, Chart))
    save = partial(figure(chart).savefig, dpi=80, metadata={"Software": None})
    return write_atomically(folder / f"{answer.name}.png", save), answer.section.title


def main(words: Sequence[str] | None = None) -> Path:
    """Write the report of all questions, and each question's picture beside it; the report's path."""
    parser = argparse.ArgumentParser(
        prog="python -m motofmi.scenarios.the_full_rider", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--out", default="full_rider", type=Path, metavar="DIR", help="where to (default: full_rider)")
    path = writable(parser.parse_args(words).out / "report.html")
    found = list(answered("full rider"))
    files = [picture(each, path.parent) for each in found]
    with command_line(Command([parser.prog, *(sys.argv[1:] if words is None else words)])):
        report(found, files).write(path)
    return path


if __name__ == "__main__":
    print(main())
