"""Quantiles over the runs of a study: of root loci over speed, of transfer functions, of signals over time."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from motofmi.reports.report import new_figure
from motofmi.reports.sweep_maps import DRAWN, pair_label

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
CAPTION = "Median, and the bands from 25 to 75 % and from 5 to 95 % of the runs"
PAIRS = 6  # vehicles with devices that are drawn
COLOURS = ("#0b5394", "#c55a11", "#38761d", "#7f6000", "#741b47", "#444444")


def over_speed_figures(dataset: Any) -> list[tuple[Figure, str]]:
    """For each mode the real part and the damped frequency over speed."""
    modes = [str(name) for name in dataset["mode"].values]
    found = []
    for mode in DRAWN:
        k = modes.index(mode)
        bands = [(pair_label(dataset, v, d), _quantiles(dataset, v, d, k)) for v, d in _pairs(dataset)]
        if all(np.isnan(band).all() for _, band in bands):
            continue
        figure, (left, right) = new_figure(2, 1, width=11.0, height=4.0)
        for colour, (label, band) in zip(COLOURS, bands, strict=False):
            draw_band(left, dataset["speed"].values, band[0], colour, label)
            draw_band(right, dataset["speed"].values, band[1], colour)
        left.axhline(0.0, color="#990000", linewidth=0.8)
        left.set(xlabel="speed [m/s]", ylabel="real part [1/s]", title=mode.replace("_", "-"))
        right.set(xlabel="speed [m/s]", ylabel="damped frequency [Hz]", title=mode.replace("_", "-"))
        left.legend(fontsize="small")
        found.append((figure, f"{mode.replace('_', '-')}. {CAPTION}. Unstable above the line."))
    return found


def band_figures(dataset: Any) -> list[tuple[Figure, str]]:
    """For each result over time or frequency its quantiles; of complex results the magnitude."""
    found = []
    for name, array in dataset.data_vars.items():
        along = next((dim for dim in ("time", "frequency") if dim in array.dims), None)
        if along is None:
            continue
        figure, ax = new_figure()
        for colour, (v, d) in zip(COLOURS, _pairs(dataset), strict=False):
            values = array.isel(vehicle=v, device=d).transpose(..., along).values.reshape(-1, dataset.sizes[along])
            values = np.abs(values) if np.iscomplexobj(values) else values
            draw_band(ax, dataset[along].values, quantiles_of(values), colour, pair_label(dataset, v, d))
        unit, axis = array.attrs.get("units", ""), dataset[along].attrs.get("units", "")
        ax.set(xlabel=f"{along} [{axis}]", ylabel=f"{name} [{unit}]")
        ax.legend(fontsize="small")
        found.append((figure, f"{name}. {CAPTION}."))
    return found


def draw_band(ax: Any, x: np.ndarray, band: np.ndarray, colour: str, label: str = "") -> None:
    """Median and two bands of quantiles (5, n) over x (n,)."""
    ax.fill_between(x, band[0], band[4], color=colour, alpha=0.12, linewidth=0)
    ax.fill_between(x, band[1], band[3], color=colour, alpha=0.25, linewidth=0)
    ax.plot(x, band[2], color=colour, label=label or None)


def quantiles_of(values: np.ndarray) -> np.ndarray:
    """The QUANTILES (5, n) of values (runs, n), without those that are not defined."""
    found = np.full((len(QUANTILES), values.shape[1]), np.nan)
    some = ~np.isnan(values).all(axis=0)
    found[:, some] = np.nanquantile(values[:, some], QUANTILES, axis=0)
    return found


def _quantiles(dataset: Any, vehicle: int, device: int, mode: int) -> np.ndarray:
    """Quantiles (2, 5, speeds) of the real part [1/s] and of the damped frequency [Hz]."""
    values = dataset["eigenvalue"].isel(vehicle=vehicle, device=device, mode=mode).transpose(..., "speed").values
    values = values.reshape(-1, dataset.sizes["speed"])
    return np.stack([quantiles_of(values.real), quantiles_of(values.imag / (2 * np.pi))])


def _pairs(dataset: Any) -> list[tuple[int, int]]:
    return [(v, d) for v in range(dataset.sizes["vehicle"]) for d in range(dataset.sizes["device"])][:PAIRS]
