"""Runs that compute the named modes of a system over the speeds of the study."""

from typing import Any

import numpy as np

from motofmi.studies.runs import Column, Computed, Coordinate, Result
from motofmi.workflows.sweep.system_runs import NUMERIC, SystemRuns, speeds_of
from motofmi.workflows.sweep.systems import Systems
from vehicle_fmu import MODES
from vehicle_fmu.stacked_modes import StackedModes, grid_of, stacked_modes

SPECTRUM = 60e-6  # s of processor time for a named spectrum: benchmarks/sweep.py


class ModesRuns(SystemRuns):
    """The eigenvalue of every mode at every speed, and whether it is unstable there.

    The table has for each mode the lowest and the highest speed at which it is unstable, between which it may be stable
    where `bands` is above 1; the least damping ratio and its speed.
    """

    @classmethod
    def checked(cls, study: Any, systems: Systems) -> dict[str, Any]:
        return {"speed": speeds_of(study.speed, systems)}

    def describe(self) -> None:
        speeds = self.options["speed"]
        shape = (len(MODES), len(speeds))
        self.results = {
            "eigenvalue": Result(("mode", "speed"), shape, "complex128", "1/s", "eigenvalue with Im >= 0"),
            "unstable": Result(("mode", "speed"), shape, "int8", "1", "1 unstable, 0 stable, -1 absent"),
        }
        self.extra = {
            "mode": Coordinate("mode", list(MODES)),
            "speed": Coordinate("speed", speeds, "m/s", "forward speed"),
        }
        self.values = {f"{mode}_{name}": column for mode in MODES for name, column in (
            ("from", Column(NUMERIC, "m/s")), ("to", Column(NUMERIC, "m/s")), ("bands", Column("int64", "1")),
            ("damping_ratio", Column(NUMERIC, "1")), ("damping_speed", Column(NUMERIC, "m/s")))}  # fmt: skip

    def cost(self) -> float:
        return SPECTRUM * len(grid_of(self.options["speed"]))

    def of_system(self, vehicle: int, device: int, indices: np.ndarray) -> Computed:
        speeds = self.options["speed"]
        found = stacked_modes(self.systems.stacked(vehicle, device, indices), len(indices), speeds)
        real = found.eigenvalue.real
        unstable = np.where(np.isnan(real), -1, real > 0).astype(np.int8)
        return Computed({"eigenvalue": found.eigenvalue, "unstable": unstable}, _columns(found))


def _columns(found: StackedModes) -> dict[str, Any]:
    """The columns of the table."""
    members = len(found.eigenvalue)
    columns: dict[str, Any] = {}
    for k, mode in enumerate(MODES):
        bands = found.unstable[found.unstable[:, 1] == k]
        member = bands[:, 0].astype(int)
        low, high = np.full(members, np.nan), np.full(members, np.nan)
        low[member[::-1]], high[member] = bands[::-1, 2], bands[:, 3]
        values = found.eigenvalue[:, k]
        ratio = np.where(values.imag > 0, -values.real / np.abs(values), np.inf)
        least = ratio.argmin(axis=1)
        smallest = ratio[np.arange(members), least]
        oscillates = np.isfinite(smallest)
        columns |= {
            f"{mode}_from": _or_none(low), f"{mode}_to": _or_none(high),
            f"{mode}_bands": np.bincount(member, minlength=members).tolist(),
            f"{mode}_damping_ratio": _or_none(np.where(oscillates, smallest, np.nan)),
            f"{mode}_damping_speed": _or_none(np.where(oscillates, found.speed[least], np.nan)),
        }  # fmt: skip
    return columns


def _or_none(values: np.ndarray) -> list[float | None]:
    """Numbers, None for those that are not defined."""
    return [None if np.isnan(value) else float(value) for value in values]
