"""The questions about the full rider and the rider in roll, answered in one report.

python -m motofmi.scenarios.the_full_rider --out full_rider
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from motofmi.reports.chart_figures import figure
from motofmi.reports.charts import Chart
from motofmi.reports.report import Report, Section, Table
from motofmi.workflows.scenarios import answered

ASKED = "What does a rider of six bodies, or one who leans, add to the passive rider of 2011?"
LEAD = ("The six-body rider of 2008 and the rider in roll: where their inertias come from, how far kinematics goes, "
        "what the gap workflow says of them, "
        "and what lean does to weave. Every number below was computed by this run.")  # fmt: skip


def main(words: Sequence[str] | None = None) -> Path:
    """Write the report of all questions, and each question's picture beside it as a PNG of its
    name; the report's path."""
    parser = argparse.ArgumentParser(
        prog="python -m motofmi.scenarios.the_full_rider", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--out", default="full_rider", type=Path, metavar="DIR", help="where to (default: full_rider)")
    path = parser.parse_args(words).out / "report.html"
    results = list(answered("full rider"))
    overview = Table(("question", "answer"), [(each.section.title, each.section.paragraphs[0]) for each in results])
    Report(
        "motofmi: the full rider",
        LEAD,
        [Section("All answers", [], [], [overview]), *(each.section for each in results)],
        asked=ASKED,
    ).write(path)
    for each in results:
        picture = next(shown for shown, _ in each.section.figures if isinstance(shown, Chart))
        figure(picture).savefig(path.parent / f"{each.name}.png", dpi=80, metadata={"Software": None})
    return path


if __name__ == "__main__":
    print(main())
