"""Which riders make a motorcycle weave, at which speed, and which damper serves most of them?

The riders are drawn from the population of the ten riders of Cossalter, Doria, Lot, Massaro, Meccanica 46 (2011),
Table 2: log-normal with their means, standard deviations and correlations. Each rides every vehicle with every damper
at 1 to 60 m/s. A rider is served by a damper if weave and wobble are stable from LOWEST to 60 m/s; below, the rider
steers, and a passive rider says little.
"""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel
from motofmi.reports.report import Section, Table
from motofmi.workflows.sweep.result import StudyResult
from motofmi.workflows.sweep.sweep import sweep

VEHICLES = ("sharp_1971", "reference_2011", "benchmark_bicycle")
DAMPERS = ("none", "damper:low_2011", "damper:medium_2011", "damper:high_2011", "damper:inerter")
SPEEDS = np.arange(1.0, 60.1, 1.0)
LOWEST = 10.0  # m/s
RIDERS = 256
MODES = ("weave", "wobble")


@dataclass(frozen=True)
class Answer:
    """Shares by vehicle and damper: of riders that weave or wobble at some speed from LOWEST, of those that are served,
    and the share that weaves over speed (n,)."""

    speeds: np.ndarray
    riders: int
    weaving: dict[tuple[str, str], float]
    wobbling: dict[tuple[str, str], float]
    served: dict[tuple[str, str], float]
    over_speed: dict[tuple[str, str], np.ndarray]

    @property
    def best(self) -> dict[str, str]:
        """The damper that serves most riders, by vehicle."""
        vehicles = dict.fromkeys(vehicle for vehicle, _ in self.served)
        return {vehicle: max((damper for v, damper in self.served if v == vehicle),
                             key=lambda damper: self.served[vehicle, damper]) for vehicle in vehicles}  # fmt: skip


def run(vehicles: Sequence[str] = VEHICLES, dampers: Sequence[str] = DAMPERS, riders: int = RIDERS,
        speeds: np.ndarray = SPEEDS, folder: str | None = None) -> Answer:  # fmt: skip
    """Study so many riders of the population; the store goes into a folder, by default a temporary one."""
    with tempfile.TemporaryDirectory() as temporary:
        found = sweep(vehicle=list(vehicles), device=list(dampers), speed=speeds, count=riders,
                      set={"rider": "~riders_2011"}, out=Path(folder or temporary) / "riders")  # fmt: skip
        return answer(found, riders)


def answer(found: StudyResult, riders: int) -> Answer:
    """The shares of a study over vehicles, devices and riders."""
    speeds = found.dataset["speed"].values
    unstable = {mode: (found.dataset["unstable"].sel(mode=mode) == 1) for mode in MODES}
    shares: dict[str, dict[tuple[str, str], Any]] = {name: {} for name in ("weave", "wobble", "served", "speed")}
    for v, vehicle in enumerate(found.dataset["vehicle"].values):
        for d, device in enumerate(found.dataset["device"].values):
            each = {mode: array.isel(vehicle=v, device=d).transpose("rider", "speed").values
                    for mode, array in unstable.items()}  # fmt: skip
            fast = {mode: values[:, speeds >= LOWEST].any(axis=1) for mode, values in each.items()}
            pair = str(vehicle), str(device)
            for mode in MODES:
                shares[mode][pair] = float(fast[mode].mean())
            shares["served"][pair] = float(1.0 - (fast["weave"] | fast["wobble"]).mean())
            shares["speed"][pair] = each["weave"].mean(axis=0)
    return Answer(speeds, riders, shares["weave"], shares["wobble"], shares["served"], shares["speed"])


def chart(found: Answer) -> Chart:
    """The share of riders that weave over speed: a panel for each vehicle, a curve for each damper."""
    dampers = list(dict.fromkeys(damper for _, damper in found.served))
    panels = []
    for vehicle in found.best:
        curves = [Curve(damper.removeprefix("damper:"), found.speeds, 100 * found.over_speed[vehicle, damper], SEQUENCE[k])
                  for k, damper in enumerate(dampers)]  # fmt: skip
        axes = Axis("speed", "m/s"), Axis("share of riders that weave", "%", low=0.0, high=100.0)
        panels.append(Panel(*axes, curves, vehicle))
    return Chart(panels, columns=len(panels))


def section(found: Answer) -> Section:
    """Which damper serves most riders, with the shares of all."""
    texts = [f"{vehicle}: {best.removeprefix('damper:')} serves most, {100 * found.served[vehicle, best]:.0f} % of "
             f"{found.riders} riders." for vehicle, best in found.best.items()]  # fmt: skip
    rows = [[vehicle, damper.removeprefix("damper:"), *(f"{100 * share[vehicle, damper]:.0f}"
             for share in (found.weaving, found.wobbling, found.served))] for vehicle, damper in found.served]  # fmt: skip
    table = Table(["vehicle", "damper", "weave [%]", "wobble [%]", "served [%]"], rows,
                  f"Share of riders with an unstable mode at some speed from {LOWEST:g} to {found.speeds[-1]:g} m/s")  # fmt: skip
    return Section(
        "Which riders make a motorcycle weave?", texts, [(chart(found), "Share of riders that weave.")], [table]
    )
