"""Figures of a steer test's gap: where the base deviates in every run, and one run before and after."""

from motofmi.gap.localisation.harmonic_places import cells
from motofmi.gap.localisation.locating import locate
from motofmi.gap.selection.result import Verdict
from motofmi.reports.gap_before_after import figures, shown_run, without_and_with
from motofmi.reports.gap_map import gap_map
from motofmi.reports.gap_report import Pictures


def pictures(verdict: Verdict) -> Pictures:
    """The figures of a report for a verdict on steer tests."""
    missed = locate(verdict.base, cells, verdict.criteria)
    maps = [(gap_map(verdict.base, missed, i, k), f"{r.name}, {output.column}: recording, response, and what the base "
                                                  "leaves by order, band, amplitude and direction.")
            for i, r in enumerate(verdict.base.runs) for k, output in enumerate(r.outputs)]  # fmt: skip
    return Pictures(maps, figures(without_and_with(verdict)), shown_run(verdict))
