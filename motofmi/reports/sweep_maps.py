"""Stability maps of a study: the share of runs in which a mode is unstable, over speed and over a parameter."""

from typing import Any

import numpy as np

from motofmi.reports.charts import SEQUENCE, Axis, Cells, Chart, Curve, Panel

DRAWN = ("weave", "wobble", "rear_wobble", "rider_wobble")  # capsize is left out: riders stabilise it
MEMBERS = ("rider", "sample")
FIXED = ("vehicle", "device", "mode", "speed", *MEMBERS)
MOST = 12  # maps in one figure


def share_unstable(dataset: Any, table: Any, mode: str, keep: tuple[str, ...]) -> Any:
    """The share of the computed runs in which a mode is unstable, over the dimensions `keep` (xarray.DataArray)."""
    modes = [str(name) for name in dataset["mode"].values]
    unstable = dataset["unstable"].isel(mode=modes.index(mode))
    dims = [dim for dim in unstable.dims if dim != "speed"]
    done = (table["status"] == "done").to_numpy().reshape([unstable.sizes[dim] for dim in dims])
    computed = unstable.isel(speed=0, drop=True).copy(data=done)
    others = [dim for dim in unstable.dims if dim not in keep]
    return (unstable == 1).where(computed).mean(others)


def unstable_modes(dataset: Any) -> list[str]:
    """The oscillatory modes that are unstable in a run."""
    modes = [str(name) for name in dataset["mode"].values]
    return [mode for mode in DRAWN if bool((dataset["unstable"].isel(mode=modes.index(mode)) == 1).any())]


def grid_parameters(dataset: Any) -> list[str]:
    """The dimensions that are parameters with several values."""
    return [str(dim) for dim in dataset["unstable"].dims if dim not in FIXED and dataset.sizes[dim] > 1]


def share_chart(dataset: Any, table: Any, modes: list[str]) -> tuple[Chart, str]:
    """The share of unstable runs over speed: a panel for each mode, a curve for each vehicle and device."""
    panels = []
    for mode in modes:
        share = share_unstable(dataset, table, mode, ("vehicle", "device", "speed"))
        curves = [Curve(pair_label(dataset, v, d), dataset["speed"].values,
                        100 * share.isel(vehicle=v, device=d).values, SEQUENCE[k % len(SEQUENCE)])
                  for k, (v, d) in enumerate(pairs(dataset))]  # fmt: skip
        panels.append(Panel(Axis("speed", "m/s"), Axis("share of runs unstable", "%", low=0.0, high=100.0), curves,
                            mode.replace("_", "-")))  # fmt: skip
    return Chart(panels, columns=min(2, len(panels))), "Share of the runs in which each mode is unstable, over speed."


def map_charts(dataset: Any, table: Any, modes: list[str]) -> list[tuple[Chart, str]]:
    """For each mode and parameter maps of speed against the parameter, one for each vehicle and device."""
    found = [(_maps(dataset, table, mode, parameter),
              f"{mode.replace('_', '-')}: share of the runs that are unstable, over speed and {parameter}; without "
              "colour where none is, and without a map for a device with which none is.")
             for mode in modes for parameter in grid_parameters(dataset)]  # fmt: skip
    return [(chart, caption) for chart, caption in found if chart.panels]


def _maps(dataset: Any, table: Any, mode: str, parameter: str) -> Chart:
    share = share_unstable(dataset, table, mode, ("vehicle", "device", parameter, "speed"))
    share = share.transpose("vehicle", "device", parameter, "speed").sortby(parameter)
    (x, x_end), (y, y_end) = (_edges(share[name].values) for name in ("speed", parameter))
    axes = Axis("speed", "m/s"), Axis(parameter, dataset[parameter].attrs.get("units", ""))
    panels = []
    some = [pair for pair in pairs(dataset) if (share[pair] > 0).any()]  # where nothing is unstable a map is empty
    for vehicle, device in some[:MOST]:
        values = 100 * share[vehicle, device].values
        row, column = np.nonzero(values > 0)
        cells = Cells(x[column], x_end[column], y[row], y_end[row], values[row, column], "share of runs unstable [%]",
                      1.0, 100.0)  # fmt: skip
        panels.append(Panel(*axes, title=pair_label(dataset, vehicle, device), cells=cells, hover="point"))
    return Chart(panels, columns=min(2, len(panels)),
                 words=f"Share of the runs in which {mode} is unstable, over speed and {parameter}")  # fmt: skip


def _edges(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The lower and the upper ends of cells around ascending values (n,)."""
    middle = (values[1:] + values[:-1]) / 2
    ends = np.concatenate([[values[0] - (middle[0] - values[0]) if len(middle) else values[0] - 0.5], middle,
                           [values[-1] + (values[-1] - middle[-1]) if len(middle) else values[0] + 0.5]])  # fmt: skip
    return ends[:-1], ends[1:]


def pairs(dataset: Any) -> list[tuple[int, int]]:
    """The indices of every vehicle with every device."""
    return [(v, d) for v in range(dataset.sizes["vehicle"]) for d in range(dataset.sizes["device"])]


def pair_label(dataset: Any, vehicle: int, device: int) -> str:
    """The name of a vehicle with a device; of several vehicles also the vehicle's."""
    name = str(dataset["device"].values[device])
    whole = str(dataset["vehicle"].values[vehicle])
    return f"{whole}, {name}" if dataset.sizes["vehicle"] > 1 else name
