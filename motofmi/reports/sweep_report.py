"""The report of a study as one HTML file: stability maps, quantile bands, sensitivities, worst runs, failures."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from motofmi.reports.report import Report, Section, Table
from motofmi.reports.sweep_bands import band_charts, over_speed_charts
from motofmi.reports.sweep_maps import map_charts, share_chart, unstable_modes
from motofmi.reports.sweep_sensitivity import sensitivity_section

WORST = 10  # runs that are listed
FILE = "report.html"
FAILED = "failed"


def sweep_report(dataset: Any, table: Any, description: Mapping[str, Any]) -> Report:
    """The report of a study from its results (xarray.Dataset), its table (pandas.DataFrame) and description."""
    sizes = " x ".join(f"{n} {dim}" for dim, n in dataset.sizes.items())
    failed = table[table["status"] == FAILED]
    lead = f"{len(table):,} runs of kind {description['kind']}, {len(failed):,} failed; {sizes}."
    if "unstable" in dataset:
        sections = _of_modes(dataset, table)
    else:
        sections = [Section("Quantiles over the runs", [], band_charts(dataset))]
    if len(failed):
        sections.append(_failures(failed))
    sections.append(_provenance(description))
    return Report(f"Study {description['hash'][:8]}", lead, sections)


def _of_modes(dataset: Any, table: Any) -> list[Section]:
    modes = unstable_modes(dataset)
    if not modes:
        sections = [Section("Stability", ["No mode is unstable in any run."])]
    else:
        sections = [Section("Stability", [_sentence(table, mode) for mode in modes],
                            [share_chart(dataset, table, modes), *map_charts(dataset, table, modes)])]  # fmt: skip
    sections.append(Section("Quantiles over the runs", [], over_speed_charts(dataset)))
    found = sensitivity_section(dataset, table)
    if found is not None:
        sections.append(found)
    return [*sections, _worst(dataset, table, modes)]


def _sentence(table: Any, mode: str) -> str:
    done = table[table["status"] != FAILED]
    share = 100 * float((done[f"{mode}_bands"] > 0).mean())
    lowest = done[f"{mode}_from"].min()
    return (f"{mode.replace('_', '-')} is unstable at some speed in {share:.0f} % of the runs, "
            f"from {lowest:.1f} m/s upwards.")  # fmt: skip


def _worst(dataset: Any, table: Any, modes: list[str]) -> Section:
    """The runs with the smallest damping ratios of the unstable modes that oscillate, and how to repeat one."""
    tables = []
    labels = [name for name in table.columns[: list(table.columns).index("status")] if name != "run"]
    for mode in modes or ["weave"]:
        column = f"{mode}_damping_ratio"
        least = table.nsmallest(WORST, column)
        rows = [[*(_text(row[name]) for name in labels), _text(row[column]), _text(row[f"{mode}_damping_speed"])]
                for _, row in least.iterrows()]  # fmt: skip
        if rows:
            headings = [*labels, "damping ratio [1]", "at speed [m/s]"]
            tables.append(Table(headings, rows, f"{mode.replace('_', '-')}: the runs with the smallest damping ratio"))
    text = ("The parameters of a run are those of its row: motofmi modes --device rider:mean_2011 --set NAME=VALUE ... "
            "repeats it, and motofmi explore shows it with sliders.")  # fmt: skip
    return Section("Worst runs", [text], [], tables)


def _failures(failed: Any) -> Section:
    reasons = failed["reason"].value_counts()
    rows = [[str(count), reason, str(int(failed["run"][failed["reason"] == reason].iloc[0]))]
            for reason, count in reasons.head(20).items()]  # fmt: skip
    return Section("Failed runs", [], [], [Table(["runs", "reason", "first run"], rows)])


def _provenance(description: Mapping[str, Any]) -> Section:
    rows = [
        [key, str(description[key])] for key in ("version", "hash", "kind", "labels", "set", "count", "design", "seed")
    ]
    return Section("Provenance", [], [], [Table(["", ""], rows)])


def _text(value: Any) -> str:
    if isinstance(value, str):
        return value
    return "-" if value is None or np.isnan(value) else f"{value:.5g}"
