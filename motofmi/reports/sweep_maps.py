"""Stability maps of a study: the share of runs in which a mode is unstable, over speed and over a parameter."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from motofmi.reports.report import new_figure

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


def share_figure(dataset: Any, table: Any, modes: list[str]) -> tuple[Figure, str]:
    """The share of unstable runs over speed, a line for each vehicle and device."""
    figure, axes = new_figure(len(modes), 1, width=max(8.0, 4.5 * len(modes)), height=4.0)
    axes = np.atleast_1d(axes)
    for ax, mode in zip(axes, modes, strict=True):
        share = share_unstable(dataset, table, mode, ("vehicle", "device", "speed"))
        for vehicle in range(dataset.sizes["vehicle"]):
            for device in range(dataset.sizes["device"]):
                ax.plot(dataset["speed"], 100 * share.isel(vehicle=vehicle, device=device),
                        label=pair_label(dataset, vehicle, device))  # fmt: skip
        ax.set(title=mode.replace("_", "-"), xlabel="speed [m/s]", ylim=(-2, 102))
    axes[0].set_ylabel("share of runs unstable [%]")
    axes[-1].legend(fontsize="small")
    return figure, "Share of the runs in which each mode is unstable, over speed."


def map_figures(dataset: Any, table: Any, modes: list[str]) -> list[tuple[Figure, str]]:
    """For each mode and parameter maps of speed against the parameter, one for each vehicle and device."""
    return [(_maps(dataset, table, mode, parameter),
             f"{mode.replace('_', '-')}: share of the runs that are unstable, over speed and {parameter}.")
            for mode in modes for parameter in grid_parameters(dataset)]  # fmt: skip


def _maps(dataset: Any, table: Any, mode: str, parameter: str) -> Figure:
    pairs = [(v, d) for v in range(dataset.sizes["vehicle"]) for d in range(dataset.sizes["device"])][:MOST]
    columns = min(3, len(pairs))
    rows = -(-len(pairs) // columns)
    figure, axes = new_figure(columns, rows, width=4.2 * columns + 1, height=3.4 * rows + 0.4)
    axes = np.atleast_1d(axes)
    share = share_unstable(dataset, table, mode, ("vehicle", "device", parameter, "speed"))
    share = share.transpose("vehicle", "device", parameter, "speed")
    values = np.sort(dataset[parameter].values)
    order = np.argsort(dataset[parameter].values)
    image = None
    for ax, (vehicle, device) in zip(axes.flat, pairs, strict=False):
        image = ax.pcolormesh(dataset["speed"], values, 100 * share[vehicle, device].values[order], cmap="Reds", vmin=0,
                              vmax=100, shading="nearest", rasterized=True)  # fmt: skip
        ax.set(title=pair_label(dataset, vehicle, device), xlabel="speed [m/s]",
               ylabel=f"{parameter} [{dataset[parameter].attrs.get('units', '')}]")  # fmt: skip
    for ax in axes.flat[len(pairs) :]:
        ax.set_axis_off()
    if image is not None:
        figure.colorbar(image, ax=axes, label="share of runs unstable [%]")
    return figure


def pair_label(dataset: Any, vehicle: int, device: int) -> str:
    """The name of a vehicle with a device; of several vehicles also the vehicle's."""
    name = str(dataset["device"].values[device])
    whole = str(dataset["vehicle"].values[vehicle])
    return f"{whole}, {name}" if dataset.sizes["vehicle"] > 1 else name
