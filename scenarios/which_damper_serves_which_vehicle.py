"""Which steering damper serves which vehicle, with the hands off and with the passive rider?

The steering damper of each vehicle is varied (`sweep`), with nothing at the handlebar and with the mean rider of 2011.
A damper serves a vehicle best if the least damping ratio of weave and wobble over all speeds is largest; overdamped
modes do not count. Below LOWEST the rider steers, and a passive rider says little.
"""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from motofmi.reports.charts import SEQUENCE, Axis, Chart, Curve, Panel
from motofmi.reports.report import Section, Table
from motofmi.workflows.sweep.sweep import sweep
from vehicle_fmu import motorcycles

VEHICLES = ("sharp_1971", "sharp_1994", "tum_2020")
LOWEST = 10.0  # m/s
SPEEDS = np.arange(LOWEST, 60.1, 2.5)  # m/s
DEVICES = {"none": "hands off", "rider:mean_2011": "mean rider"}
DAMPING = np.linspace(0.0, 20.0, 9)  # N.m.s/rad
MODES = ("weave", "wobble")


@dataclass(frozen=True)
class Answer:
    """Least damping ratios over speed by vehicle and device: {mode: (n,)} for steering dampers (n,) [N.m.s/rad]."""

    damping: np.ndarray
    least: dict[tuple[str, str], dict[str, np.ndarray]]

    def best(self, vehicle: str, device: str) -> tuple[float, float]:
        """The best damper [N.m.s/rad] and the least damping ratio of both modes with it."""
        worst = np.min(list(self.least[vehicle, device].values()), axis=0)
        return float(self.damping[worst.argmax()]), float(worst.max())


def run(vehicles: Sequence[str] = VEHICLES, damping: np.ndarray = DAMPING, speeds: np.ndarray = SPEEDS) -> Answer:
    """The least damping ratios with steering dampers [N.m.s/rad] over speeds [m/s]."""
    least = {}
    for vehicle in vehicles:
        with tempfile.TemporaryDirectory() as folder:
            found = sweep(vehicle=vehicle, device=list(DEVICES), speed=speeds, set={"steering_damping": list(damping)},
                          out=Path(folder) / "dampers").dataset.isel(vehicle=0).load()  # fmt: skip
        order = found.transpose("device", "mode", "steering_damping", "speed")
        value = order["eigenvalue"].values
        # An overdamped mode has no damping ratio below 1.
        ratio = np.where(value.imag > 0, -value.real / np.abs(value), np.where(value.real > 0, -1.0, 1.0)).min(axis=3)
        names = list(order["mode"].values)
        for k, device in enumerate(DEVICES):
            least[vehicle, device] = {mode: ratio[k, names.index(mode)] for mode in MODES}
    return Answer(np.asarray(damping), least)


def chart(found: Answer) -> Chart:
    """The least damping ratios over the steering damper: a panel for each vehicle."""
    panels = []
    for vehicle in dict.fromkeys(v for v, _ in found.least):
        curves = [Curve(f"{mode}, {words}", found.damping, found.least[vehicle, device][mode], SEQUENCE[2 * k + i])
                  for k, (device, words) in enumerate(DEVICES.items()) for i, mode in enumerate(MODES)]  # fmt: skip
        axes = Axis("steering damper", "N.m.s/rad"), Axis("least damping ratio", "1", low=-0.2, high=0.5)
        panels.append(Panel(*axes, curves, vehicle))
    return Chart(panels, columns=len(panels))


def section(found: Answer) -> Section:
    """The best damper for each vehicle and device."""
    rows, texts = [], []
    for vehicle, device in found.least:
        damping, ratio = found.best(vehicle, device)
        shipped = motorcycles.load(vehicle).values["steering_damping"]
        rows.append([vehicle, DEVICES[device], f"{shipped:g}", f"{damping:g}", f"{ratio:.3f}",
                     "yes" if ratio > 0 else "no damper makes both stable"])  # fmt: skip
    for device, words in DEVICES.items():
        each = ", ".join(f"{found.best(v, d)[0]:g} on {v}" for v, d in found.least if d == device)
        texts.append(f"With {words} the best steering damper is {each} (N.m.s/rad).")
    table = Table(["vehicle", "at the handlebar", "shipped damper [N.m.s/rad]", "best of those tried", "least damping ratio",
                   "weave and wobble stable"], rows,
                  f"Steering dampers from {found.damping[0]:g} to {found.damping[-1]:g} N.m.s/rad; speeds from {LOWEST:g} m/s")  # fmt: skip
    return Section("Which steering damper serves which vehicle?", texts, [(chart(found), "Least damping ratio over all speeds.")], [table])
