"""Quantiles over the runs of a study: of root loci over speed, of transfer functions, of signals over time."""

from typing import Any

import numpy as np

from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Line, Panel
from motofmi.reports.sweep_maps import DRAWN, pair_label, pairs

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
CAPTION = "Median, and the bands from 25 to 75 % and from 5 to 95 % of the runs"
PAIRS = 6  # vehicles with devices that are drawn


def over_speed_charts(dataset: Any) -> list[tuple[Chart, str]]:
    """For each mode the real part and the damped frequency over speed."""
    modes, speed = [str(name) for name in dataset["mode"].values], dataset["speed"].values
    found = []
    for mode in DRAWN:
        k = modes.index(mode)
        bands = [(pair_label(dataset, v, d), _quantiles(dataset, v, d, k)) for v, d in pairs(dataset)[:PAIRS]]
        if all(np.isnan(band).all() for _, band in bands):
            continue
        left, right = ([curve for colour, (label, band) in zip(SEQUENCE, bands, strict=False)
                        for curve in band_curves(speed, band[part], colour, label)] for part in (0, 1))  # fmt: skip
        panels = [Panel(Axis("speed", "m/s"), Axis("real part", "1/s"), left, lines=[Line(0.0, "unstable above")]),
                  Panel(Axis("speed", "m/s"), Axis("damped frequency", "Hz"), right)]  # fmt: skip
        found.append((Chart(panels, columns=2, linked=True), f"{mode.replace('_', '-')}. {CAPTION}."))
    return found


def band_charts(dataset: Any) -> list[tuple[Chart, str]]:
    """For each result over time or frequency its quantiles; of complex results the magnitude."""
    found = []
    for name, array in dataset.data_vars.items():
        along = next((dim for dim in ("time", "frequency") if dim in array.dims), None)
        if along is None:
            continue
        curves = []
        for colour, (v, d) in zip(SEQUENCE, pairs(dataset)[:PAIRS], strict=False):
            values = array.isel(vehicle=v, device=d).transpose(..., along).values.reshape(-1, dataset.sizes[along])
            values = np.abs(values) if np.iscomplexobj(values) else values
            curves += band_curves(dataset[along].values, quantiles_of(values), colour, pair_label(dataset, v, d))
        unit, axis = array.attrs.get("units", ""), dataset[along].attrs.get("units", "")
        found.append((Chart([Panel(Axis(along, axis), Axis(str(name), unit), curves)]), f"{name}. {CAPTION}."))
    return found


def band_curves(x: np.ndarray, band: np.ndarray, colour: str, label: str) -> list[Curve]:
    """The median with its two bands of quantiles (5, n) over x (n,)."""
    return [Curve(label, x, band[2], colour, band=(band[0], band[4])),
            Curve(label, x, band[2], colour, band=(band[1], band[3]))]  # fmt: skip


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
