"""What all kinds of run have in common: the dimensions vehicle, device, members of a population and parameters."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil
from typing import Any, ClassVar

import numpy as np

from fmus.declaration.component import Component, in_bounds
from motofmi.studies.axes import numbers
from motofmi.studies.run_grid import RunGrid
from motofmi.studies.runs import Column, Computed, Coordinate, Runs
from motofmi.workflows.sweep.systems import Systems, groups
from vehicle_fmu.named_modes import ascending_speeds

CHUNK_SECONDS = 0.5  # processor time of a chunk, by the nominal cost of a run: the engine's part is then below 5 %
NUMERIC, TEXT = "float64", "string"
SPEEDS = np.arange(1.0, 61.0)  # m/s


@dataclass
class SystemRuns(Runs):
    """Runs over the dimensions `vehicle`, `device` and those of `axes`: their coordinates by name.

    parameters are labels of a run by column: the dimension, the values along it, and the unit.
    """

    OPTIONS: ClassVar[tuple[str, ...]] = ()  # keys of a study of this kind
    VEHICLE: ClassVar[bool] = True  # whether the devices act on a vehicle

    systems: Systems
    names: dict[str, list[str]]
    axes: dict[str, Coordinate]
    parameters: dict[str, tuple[int, np.ndarray, str]]
    options: dict[str, Any]
    extra: dict[str, Coordinate] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self.describe()
        lengths = [len(labels) for labels in self.names.values()] + [len(axis.values) for axis in self.axes.values()]
        dims = [*self.names, *self.axes]
        self.grid = RunGrid.divided(dims, lengths, ceil(CHUNK_SECONDS / self.cost()))
        self.labels = {**dict.fromkeys(self.names, Column(TEXT)),
                       **{name: Column(NUMERIC if values.dtype.kind == "f" else TEXT, unit)
                          for name, (_, values, unit) in self.parameters.items()}}  # fmt: skip
        along = {n: Coordinate(dims[dim], values, unit) for n, (dim, values, unit) in self.parameters.items()}
        self.coordinates = {**{dim: Coordinate(dim, labels) for dim, labels in self.names.items()},
                            **along, **self.axes, **self.extra}  # fmt: skip

    @classmethod
    def checked(cls, study: Any, systems: Systems) -> dict[str, Any]:
        """The options of the kind with their defaults. Raises InputError for those that cannot be used."""
        raise NotImplementedError

    @classmethod
    def axes_of(cls, options: dict[str, Any]) -> dict[str, Coordinate]:
        """Further dimensions of the grid of runs."""
        return {}

    def stated(self) -> dict[str, Any]:
        """The options for the description of the study."""
        return {
            name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in self.options.items()
        }

    def describe(self) -> None:
        """Set `results`, `values` and the coordinates `extra` of the kind."""
        raise NotImplementedError

    def cost(self) -> float:
        """The nominal processor time of one run [s]; it does not depend on the machine, so that chunks do not."""
        raise NotImplementedError

    def of_system(self, vehicle: int, device: int, indices: np.ndarray) -> Computed:
        """The runs of one vehicle and one device."""
        raise NotImplementedError

    def at(self, axis: str, place: np.ndarray) -> Any:
        """The value of an option at a place (dims,) of the grid, where it may be a dimension."""
        values = self.options[axis]
        return values[place[len(self.names) + list(self.axes).index(axis)]] if axis in self.axes else values[0]

    def labels_of(self, indices: np.ndarray) -> dict[str, Sequence[Any]]:
        """The names of vehicle and device, and the values of the parameters."""
        named = {dim: [labels[i] for i in indices[:, k]] for k, (dim, labels) in enumerate(self.names.items())}
        return {**named, **{n: values[indices[:, dim]] for n, (dim, values, _) in self.parameters.items()}}

    def results_of(self, indices: np.ndarray) -> Computed:
        """The runs of each vehicle and device together."""
        arrays = {name: np.full((len(indices), *result.shape), result.absent, result.dtype)
                  for name, result in self.results.items()}  # fmt: skip
        columns: dict[str, Any] = {name: np.full(len(indices), None, object) for name in self.values}
        for vehicle, device, rows in groups(indices):
            found = self.of_system(vehicle, device, indices[rows])
            for name, values in found.arrays.items():
                arrays[name][rows] = values
            for name, column in found.columns.items():
                columns[name][rows] = column
        return Computed(arrays, columns)


def speeds_of(given: Any, systems: Systems, default: np.ndarray = SPEEDS) -> np.ndarray:
    """Ascending speeds (n,) [m/s]: an array, one value, or text A:B:STEP. Raises InputError for any other, and for
    speeds outside a vehicle's bounds."""
    if isinstance(given, str):
        given = numbers(given, "speed", "m/s", zero=True)
    speeds = ascending_speeds(default if given is None else given)
    for vehicle in systems.vehicles:
        if isinstance(vehicle, Component):
            for end in (speeds[0], speeds[-1]):
                in_bounds(end, vehicle.table["speed"], vehicle.name)
    return speeds
