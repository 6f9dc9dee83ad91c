"""What a kind of run defines for a study: its grid, its results by name, and the function that computes a part of
it."""

import warnings
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmus.support.errors import InputError, SimulationError
from motofmi.studies.run_grid import RunGrid

DONE, FAILED = "done", "failed"


@dataclass(frozen=True)
class Result:
    """A result of every run: its further dimensions with their lengths, its type (of NumPy), unit and meaning."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: str
    unit: str
    meaning: str

    @property
    def absent(self) -> Any:
        """The value of a run that failed or was not computed."""
        return {"c": complex(np.nan, np.nan), "f": np.nan, "i": -1}[np.dtype(self.dtype).kind]


@dataclass(frozen=True)
class Coordinate:
    """Values (n,) along a dimension, numbers or names, with their unit and meaning."""

    dim: str
    values: Sequence[Any] | np.ndarray
    unit: str = ""
    meaning: str = ""


@dataclass(frozen=True)
class Column:
    """A column of the table that has a row for each run: its type (of Arrow) and unit."""

    dtype: str
    unit: str = ""


OWN = {"run": Column("int64"), "status": Column("string"), "reason": Column("string")}


@dataclass
class Computed:
    """What some runs gave: arrays (n, ...) by result, and the columns (n) of the table."""

    arrays: dict[str, np.ndarray]
    columns: Mapping[str, Sequence[Any]]


class Runs(ABC):
    """The runs of a study. It is pickled once for each worker.

    labels are the columns that identify a run, values those that a run gives.
    """

    grid: RunGrid
    coordinates: Mapping[str, Coordinate]
    results: Mapping[str, Result]
    labels: Mapping[str, Column]
    values: Mapping[str, Column]

    @property
    def columns(self) -> dict[str, Column]:
        """All columns of the table."""
        return {"run": OWN["run"], **self.labels, "status": OWN["status"], "reason": OWN["reason"], **self.values}

    @abstractmethod
    def labels_of(self, indices: np.ndarray) -> dict[str, Sequence[Any]]:
        """The columns that identify the runs at places (n, dims) of the grid."""

    @abstractmethod
    def results_of(self, indices: np.ndarray) -> Computed:
        """The results of runs, and the columns `values`. Raises what goes wrong in any of them."""

    def compute(self, indices: np.ndarray) -> Computed:
        """The runs at places (n, dims); where one fails, each is computed by itself and the reasons are recorded."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # a run either fails or is complete; its columns say how good it is
                found = self.results_of(indices)
        except Exception as error:
            if len(indices) == 1:
                return self.failed(indices, _reason(error))
            return _joined([self.compute(one[None]) for one in indices])
        own = self._own(indices, DONE, "")
        return Computed(found.arrays, {**own, **self.labels_of(indices), **found.columns})

    def failed(self, indices: np.ndarray, reason: str) -> Computed:
        """The record of runs that gave no results."""
        count = len(indices)
        own = self._own(indices, FAILED, reason)
        arrays = {name: np.full((count, *result.shape), result.absent, result.dtype)
                  for name, result in self.results.items()}  # fmt: skip
        return Computed(arrays, {**own, **self.labels_of(indices), **{name: [None] * count for name in self.values}})

    def _own(self, indices: np.ndarray, status: str, reason: str) -> dict[str, Sequence[Any]]:
        """The columns OWN."""
        return {"run": self.grid.numbers(indices).tolist(), "status": [status] * len(indices),
                "reason": [reason] * len(indices)}  # fmt: skip


def _reason(error: Exception) -> str:
    """The reason of a failure in one line; errors that are not meant for users with their type."""
    text = " ".join(str(error).split())
    return text if isinstance(error, InputError | SimulationError) else f"{type(error).__name__}: {text}"


def _joined(parts: Sequence[Computed]) -> Computed:
    arrays = {name: np.concatenate([part.arrays[name] for part in parts]) for name in parts[0].arrays}
    return Computed(arrays, {name: [value for part in parts for value in part.columns[name]]
                             for name in parts[0].columns})  # fmt: skip
