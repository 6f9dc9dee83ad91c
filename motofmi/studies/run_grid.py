"""The runs of a study: a grid of named dimensions, divided into chunks that are boxes of the grid."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, prod

import numpy as np


@dataclass(frozen=True)
class RunGrid:
    """dims and shape of the grid, and the shape of a chunk. Runs and chunks are numbered in C order.

    grid = RunGrid.divided(("device", "rider"), (10, 1000), most=64)
    grid.runs, grid.chunks, grid.region(3)
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    chunk: tuple[int, ...]

    @classmethod
    def divided(cls, dims: Sequence[str], shape: Sequence[int], most: int) -> "RunGrid":
        """The grid with chunks of at most so many runs, along the last dimensions first."""
        chunk, room = [1] * len(shape), max(most, 1)
        for d in reversed(range(len(shape))):
            parts = ceil(shape[d] / min(shape[d], room))
            chunk[d] = ceil(shape[d] / parts)
            if parts > 1:
                break
            room //= shape[d]
        return cls(tuple(dims), tuple(shape), tuple(chunk))

    @property
    def runs(self) -> int:
        """The number of runs."""
        return prod(self.shape)

    @cached_property
    def chunked(self) -> tuple[int, ...]:
        """The number of chunks along each dimension."""
        return tuple(ceil(n / c) for n, c in zip(self.shape, self.chunk, strict=True))

    @property
    def chunks(self) -> int:
        """The number of chunks."""
        return prod(self.chunked)

    def place(self, number: int) -> tuple[int, ...]:
        """The place of a chunk in the grid of chunks."""
        return tuple(int(k) for k in np.unravel_index(number, self.chunked))

    def region(self, number: int) -> tuple[slice, ...]:
        """The box of runs that is a chunk."""
        return tuple(slice(k * c, min((k + 1) * c, n))
                     for k, c, n in zip(self.place(number), self.chunk, self.shape, strict=True))  # fmt: skip

    def indices(self, number: int) -> np.ndarray:
        """The place (n, dims) of every run of a chunk."""
        axes = [np.arange(part.start, part.stop) for part in self.region(number)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(self.shape))

    def numbers(self, indices: np.ndarray) -> np.ndarray:
        """The numbers (n,) of runs at places (n, dims)."""
        return np.ravel_multi_index(tuple(indices.T), self.shape)
