"""Runs that linearise a system at the speeds of the study: the matrices of x' = A x + B u, y = C x + D u."""

from typing import Any

import numpy as np

from motofmi.studies.runs import Column, Computed, Coordinate, Result
from motofmi.workflows.sweep.system_runs import SystemRuns, speeds_of
from motofmi.workflows.sweep.systems import Systems

POINT = 5e-6  # s of processor time for the matrices at one speed
SIGNALS = ("states", "inputs", "outputs")


class LinearRuns(SystemRuns):
    """A, B, C, D over speed and the names of the signals; those that a system does not have are absent (NaN)."""

    @classmethod
    def checked(cls, study: Any, systems: Systems) -> dict[str, Any]:
        speeds = speeds_of(study.speed, systems)
        names: dict[str, dict[str, None]] = {kind: {} for kind in SIGNALS}
        place = np.zeros((1, 2), int)
        for vehicle in range(len(systems.vehicles)):
            for device in range(len(systems.devices)):
                space = systems.stacked(vehicle, device, place)(np.zeros(1, int), speeds[:1])
                for kind, held in names.items():
                    held.update(dict.fromkeys(getattr(space, kind)))
        return {"speed": speeds, **{kind: list(held) for kind, held in names.items()}}

    def describe(self) -> None:
        speeds = self.options["speed"]
        states, inputs, outputs = (self.options[kind] for kind in SIGNALS)
        sizes = {"state": len(states), "state_rate": len(states), "input": len(inputs), "output": len(outputs)}
        dims = {
            "A": ("state_rate", "state"),
            "B": ("state_rate", "input"),
            "C": ("output", "state"),
            "D": ("output", "input"),
        }
        self.results = {name: Result(("speed", *own), (len(speeds), *(sizes[d] for d in own)), "float64", "SI",
                                     f"matrix {name}") for name, own in dims.items()}  # fmt: skip
        self.extra = {"speed": Coordinate("speed", speeds, "m/s", "forward speed"),
                      "state": Coordinate("state", states), "state_rate": Coordinate("state_rate", states),
                      "input": Coordinate("input", inputs), "output": Coordinate("output", outputs)}  # fmt: skip
        self.values: dict[str, Column] = {}

    def cost(self) -> float:
        return POINT * len(self.options["speed"])

    def of_system(self, vehicle: int, device: int, indices: np.ndarray) -> Computed:
        speeds, runs = self.options["speed"], len(indices)
        linearised = self.systems.stacked(vehicle, device, indices)
        space = linearised(np.repeat(np.arange(runs), len(speeds)), np.tile(speeds, runs))
        rows, columns, outputs = (
            [self.options[kind].index(n) for n in getattr(space, kind)] for kind in ("states", "inputs", "outputs")
        )
        arrays = {}
        for name, (down, across) in {
            "A": (rows, rows),
            "B": (rows, columns),
            "C": (outputs, rows),
            "D": (outputs, columns),
        }.items():
            whole = np.full((runs, *self.results[name].shape), np.nan)
            matrix = getattr(space, name).reshape(runs, len(speeds), len(down), len(across))
            whole[:, :, np.array(down, int)[:, None], np.array(across, int)] = matrix
            arrays[name] = whole
        return Computed(arrays, {})
