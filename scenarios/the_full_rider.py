"""The questions about the full rider and the rider in roll, answered in one report.

    python -m scenarios.the_full_rider --out full_rider
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from fmus.progress import track
from scenarios import (
    does_anthropometry_give_the_inertias,
    does_kinematics_explain_amplitude_dependence,
    what_do_roll_features_leave_open,
    what_does_lean_do_to_weave,
    what_does_the_gap_say_of_the_full_rider,
)
from scenarios.report import Report

QUESTIONS = (does_anthropometry_give_the_inertias, does_kinematics_explain_amplitude_dependence, what_does_the_gap_say_of_the_full_rider,
             what_do_roll_features_leave_open, what_does_lean_do_to_weave)  # fmt: skip
LEAD = ("The six-body rider of 2008 and the rider in roll: where their inertias come from, how far kinematics goes, what the gap workflow says of them, "
        "and what lean does to weave. Every number below was computed by this run.")  # fmt: skip


def main(words: Sequence[str] | None = None) -> Path:
    """Write the report of all questions, and each question's picture beside it as a PNG of its name; the report's path."""
    parser = argparse.ArgumentParser(prog="python -m scenarios.the_full_rider", description=__doc__.splitlines()[0])
    parser.add_argument("--out", default="full_rider", type=Path, metavar="DIR", help="where to (default: full_rider)")
    path = parser.parse_args(words).out / "report.html"
    sections = [question.section(question.run()) for question in track(QUESTIONS, "full rider")]
    Report("motofmi: the full rider", LEAD, sections).write(path)
    for question, section in zip(QUESTIONS, sections, strict=True):
        section.figures[0][0].savefig(path.parent / f"{question.__name__.rpartition('.')[2]}.png", dpi=80, metadata={"Software": None})
    return path


if __name__ == "__main__":
    print(main())
