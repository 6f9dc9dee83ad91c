"""The report of a study as one HTML file: stability maps, quantile bands, sensitivities, worst runs, failures."""

from collections.abc import Mapping, Sequence
from typing import Any

from motofmi.reports.report import Report, Section, Shown, Table
from motofmi.reports.sweep_bands import band_charts, over_speed_charts
from motofmi.reports.sweep_maps import map_charts, share_chart, unstable_modes
from motofmi.reports.sweep_runs import RunLinks, worst_section
from motofmi.reports.sweep_sensitivity import sensitivity_section

FILE = "report.html"
FAILED = "failed"
CAPSIZE = "Capsize is slow, and riders stabilise it: it has no map."
Figures = Sequence[tuple[Shown, str]]


def sweep_report(dataset: Any, table: Any, description: Mapping[str, Any], links: RunLinks | None = None) -> Report:
    """The report of a study from its results (xarray.Dataset), its table (pandas.DataFrame) and description."""
    failed = table[table["status"] == FAILED]
    if "unstable" in dataset:
        answer, figures, sections = _of_modes(dataset, table, links)
    else:
        charts = band_charts(dataset)
        answer, figures = "The figure shows the quantiles of the runs.", charts[:1]
        sections = [Section("Quantiles over the runs", [], charts[1:])] if charts[1:] else []
    warnings = [f"{len(failed):,} of {len(table):,} runs failed; their reasons are below."] if len(failed) else []
    if len(failed):
        sections.append(_failures(failed))
    sections.append(_provenance(description))
    dims = {dim: dataset.sizes[dim] for dim in (*description["labels"], *description["axes"]) if dim in dataset.sizes}
    asked = f"{_question(description)} {_sizes(dims, len(table))}"
    return Report("Study of " + ", ".join(description["labels"]["vehicle"]), answer, sections, figures=figures,
                  asked=asked, warnings=warnings)  # fmt: skip


def _question(description: Mapping[str, Any]) -> str:
    known = {"modes": "Which of the runs have an unstable mode, at which speed?",
             "frf": "Which torque do the devices exert over frequency?"}  # fmt: skip
    return known.get(description["kind"], "How do the runs differ?")


def _sizes(dims: Mapping[str, int], runs: int) -> str:
    """The number of runs and what it is the product of: the lengths by dimension."""
    named = {dim: f"{dim}s" for dim in ("vehicle", "device", "rider", "sample", "coupling", "step")}
    factors = [f"{n} {named.get(dim, f'values of {dim}')}" for dim, n in dims.items() if n > 1]
    return f"{runs:,} runs" + (f": {' x '.join(factors)}." if factors else ".")


def _of_modes(dataset: Any, table: Any, links: RunLinks | None) -> tuple[str, Figures, list[Section]]:
    """The answer, the figure of the first screen, and the sections."""
    modes = unstable_modes(dataset)
    over_speed = over_speed_charts(dataset)
    if modes:
        answer, figures = " ".join(_sentence(table, mode) for mode in modes), [share_chart(dataset, table, modes)]
        maps = map_charts(dataset, table, modes)
        sections = [Section("Stability maps", [], maps)] if maps else []
    else:
        answer, figures, sections = "No mode that oscillates is unstable in any run.", over_speed[:1], []
        over_speed = over_speed[1:]
    if int((table["capsize_bands"] > 0).sum()):
        answer += f" {_sentence(table, 'capsize')} {CAPSIZE}"
    if over_speed:
        sections.append(Section("Quantiles over the runs", [], over_speed))
    found = sensitivity_section(dataset, table)
    if found is not None:
        sections.append(found)
    return answer, figures, [*sections, worst_section(dataset, table, modes, links)]


def _sentence(table: Any, mode: str) -> str:
    done = table[table["status"] != FAILED]
    unstable = int((done[f"{mode}_bands"] > 0).sum())
    lowest = done[f"{mode}_from"].min()
    name, share = mode.replace("_", "-").capitalize(), f"{100 * unstable / len(done):.3g} %"
    return f"{name} is unstable at some speed in {unstable} of {len(done)} runs ({share}), first at {lowest:.1f} m/s."


def _failures(failed: Any) -> Section:
    reasons = failed["reason"].value_counts()
    rows = [[str(count), reason, str(int(failed["run"][failed["reason"] == reason].iloc[0]))]
            for reason, count in reasons.head(20).items()]  # fmt: skip
    return Section("Failed runs", [], [], [Table(["runs", "reason", "first run"], rows)])


def _provenance(description: Mapping[str, Any]) -> Section:
    keys = ("kind", "labels", "set", "count", "design", "seed", "hash")
    rows = [[key, _plain(description[key])] for key in keys if description[key] not in ({}, [])]
    return Section("What was computed", [], [], [Table(["key", "value"], rows)], folded=True)


def _plain(value: Any) -> str:
    if isinstance(value, Mapping):
        return "; ".join(f"{key}: {_plain(inner)}" for key, inner in value.items())
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)
