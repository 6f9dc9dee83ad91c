"""Single runs in the report of a study: the worst of all and of each stability map, with links that show them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motofmi.reports.report import Section, Table
from motofmi.reports.sweep_maps import grid_parameters, pair_label, pairs, share_unstable

WORST = 10  # runs that are listed
MOST_MAPS = 20  # maps whose worst run is listed
TEXT = (
    "The number of a run opens it in the explore page, as configuration B with the values of the run; A has the values "
    "of the files."
)
WITHOUT = (
    "motofmi modes --device DEVICE --set NAME=VALUE ... repeats a run with the values of its row. No explore page was "
    "written with this report: {}."
)


@dataclass(frozen=True)
class RunLinks:
    """The explore page of a study, why there is none, and the address in it of a row of the table with mode and speed
    [m/s]."""

    page: Path
    reason: str
    address: Callable[[Mapping[str, Any], str, float], str]

    def of(self, row: Mapping[str, Any], mode: str, speed: float) -> str:
        """The link to a run; empty where the page does not show it."""
        state = "" if self.reason or not np.isfinite(speed) else self.address(row, mode, float(speed))
        return self.page.name + state if state else ""


def worst_section(dataset: Any, table: Any, modes: list[str], links: RunLinks | None) -> Section:
    """The runs with the smallest damping ratios of the unstable modes that oscillate, and those of each map."""
    tables = []
    units = {name: dataset[name].attrs.get("units", "") for name in table.columns if name in dataset}
    labels = [name for name in table.columns[: list(table.columns).index("status")] if name != "run"]
    for mode in modes or ["weave"]:
        least = table.nsmallest(WORST, f"{mode}_damping_ratio")
        rows, found = [], []
        for _, row in least.iterrows():
            ratio, speed = row[f"{mode}_damping_ratio"], row[f"{mode}_damping_speed"]
            rows.append([_text(row["run"]), _text(ratio), _text(speed), *(_text(row[name]) for name in labels)])
            found.append("" if links is None else links.of(row, mode, speed))
        headings = [
            "run",
            "damping ratio [1]",
            "at speed [m/s]",
            *(_heading(name, units.get(name, "")) for name in labels),
        ]
        tables.append(Table(headings, rows, f"{_shown(mode)}: the runs with the smallest damping ratio", links=found))
    tables += _of_maps(dataset, table, modes, links)
    text = WITHOUT.format(links.reason) if links is not None and links.reason else TEXT
    shown = links is not None and not links.reason
    files = [(links.page, "every run with sliders, animated modes and live FMUs")] if shown and links else []
    return Section("Worst runs", [text], [], tables, files=files)


def _of_maps(dataset: Any, table: Any, modes: list[str], links: RunLinks | None) -> list[Table]:
    """The cell of each stability map with the largest share of unstable runs, and the least stable run in it."""
    rows, found = [], []
    for mode in modes:
        for parameter in grid_parameters(dataset):
            share = share_unstable(dataset, table, mode, ("vehicle", "device", parameter, "speed"))
            share = share.transpose("vehicle", "device", parameter, "speed")
            unit = dataset[parameter].attrs.get("units", "")
            for vehicle, device in pairs(dataset):
                part = np.nan_to_num(share[vehicle, device].values)
                if not part.any():
                    continue
                place, speed = np.unravel_index(part.argmax(), part.shape)
                at = {"vehicle": vehicle, "device": device, parameter: int(place)}
                row = table.iloc[_least_stable(dataset, mode, at, int(speed))]
                value, driven = float(dataset[parameter].values[place]), float(dataset["speed"].values[speed])
                rows.append([_text(row["run"]), _shown(mode), pair_label(dataset, vehicle, device),
                             f"{parameter} = {value:.5g} {unit}".strip(), _text(driven),
                             f"{100 * part.max():.0f}"])  # fmt: skip
                found.append("" if links is None else links.of(row, mode, driven))
    headings = ["run", "mode", "with", "where", "speed [m/s]", "share of runs unstable [%]"]
    caption = "Of each stability map the place with the largest share, and the least stable run there"
    return [Table(headings, rows[:MOST_MAPS], caption, links=found[:MOST_MAPS])] if rows else []


def _least_stable(dataset: Any, mode: str, at: Mapping[str, int], speed: int) -> int:
    """The number of the run with the largest real part of a mode at a place of some dimensions and a speed."""
    modes = [str(name) for name in dataset["mode"].values]
    real = dataset["eigenvalue"].isel(mode=modes.index(mode), speed=speed).real
    dims = list(real.dims)
    within = real.isel(at).values
    free = [dim for dim in dims if dim not in at]
    inner = np.unravel_index(np.nanargmax(within), within.shape) if free else ()
    place = {**at, **dict(zip(free, map(int, inner), strict=True))}
    return int(np.ravel_multi_index([place[dim] for dim in dims], real.shape))


def _heading(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _shown(mode: str) -> str:
    return mode.replace("_", "-")


def _text(value: Any) -> str:
    if isinstance(value, str):
        return value
    return "-" if value is None or np.isnan(value) else f"{value:.5g}"
