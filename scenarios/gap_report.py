"""The gap as one HTML report: the verdict, where the model missed, and recording, harmonics, Nyquist plane, whiteness."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from identification.gap.naming.decide import Verdict
from identification.gap.reporting.harmonic_places import cells
from identification.gap.reporting.locating import FALSE_DISCOVERIES, locate
from scenarios.gap_before_after import figures, told, without_and_with
from scenarios.gap_map import gap_map
from scenarios.gap_tables import before_and_after, modes_over_speed, places, verdict_section
from scenarios.report import Report, Section

FILE = "report.html"


@dataclass(frozen=True)
class Pictures:
    """Each picture with its caption: where the base misses every run, and one run, which is told, before and after."""

    misses: list[tuple[Figure, str]]
    before_and_after: list[tuple[Figure, str]]
    shown: str


def pictures(verdict: Verdict) -> Pictures:
    """What a report shows of a verdict."""
    missed = locate(verdict.base, cells)
    maps = [(gap_map(verdict.base, missed, i, k), f"{r.name}, {output.column}: recording, response, and what the base leaves by order, band, amplitude and direction.")
            for i, r in enumerate(verdict.base.runs) for k, output in enumerate(r.outputs)]  # fmt: skip
    return Pictures(maps, figures(without_and_with(verdict)), told(verdict))


def write_report(shown: Pictures, result: dict[str, Any], folder: Path) -> str:
    """Write the report into the folder; its name there."""
    passing = f"Places that pass a false-discovery rate of {FALSE_DISCOVERIES:.0%} (Benjamini and Hochberg), in red."
    sections = [
        verdict_section(result),
        Section("Where the base model misses", [passing], shown.misses, [places(result)]),
        Section("Before and after", [shown.shown], shown.before_and_after, [before_and_after(result)]),
        modes_over_speed(result),
    ]
    Report("The gap between model and recordings", f"Verdict: {result['verdict']}", sections).write(folder / FILE)
    return FILE
