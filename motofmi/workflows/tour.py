"""The main tasks in sequence, with one report."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from fmus.support.files import writable
from fmus.support.notebook import html
from motofmi.reports.report import Report
from motofmi.workflows.scenarios import answered

FILE = "report.html"
LEAD = ("Published riders, motorcycles and steering dampers, built as FMUs, co-simulated, and compared by their modes "
        "with what was printed. Every number below was computed by this run.")  # fmt: skip


@dataclass(frozen=True, repr=False)
class Tour:
    """The steps of a tour, each with name, seconds and answer, and the path of the report."""

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


def tour(out: str | Path = "tour", *, seed: int = 1) -> Tour:
    """Build FMUs, co-simulate them, compare modes with the published ones, find a hidden effect, and write
    one report into `out`.

    seed draws the rider and the hidden effect of the virtual rig. Raises InputError where the folder cannot be written.

        tour("tour").report
    """
    path = writable(Path(out) / FILE)
    report, steps = Report("motofmi: the tour", LEAD), []
    for each in answered("tour", out=path.parent, seed=seed):
        report.sections.append(each.section)
        steps.append({"name": each.step, "seconds": each.seconds, "answer": each.section.paragraphs[0]})
    start = perf_counter()
    report.write(path)
    steps.append({"name": "report", "seconds": perf_counter() - start, "answer": f"{path}"})
    return Tour(steps, path)
