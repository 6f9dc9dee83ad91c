"""Significant misfit: the places where a run's residuals exceed the noise, under a stated false-discovery rate.

    (z'z / n) / 1  ~  F(n, v)

for the n residuals z of a cell over the noise, where the model is true; v are the degrees of freedom of the noise
estimate (chi-square where the noise is given). The cells of all runs whose p-values pass the rate are reported.

Source: Benjamini, Hochberg, J. R. Statist. Soc. B 57 (1995) 289-300.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.special import chdtrc, fdtrc

from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.models.any_model import AnyRun


@dataclass(frozen=True)
class Place:
    """A cell along an axis, of one harmonic order or of all, with its excess (reduced chi-square
    minus 1) and p-value."""

    run: str
    axis: str
    start: float
    end: float
    unit: str
    excess: float
    p_value: float
    order: int | None = None


Cells = Callable[[Any, np.ndarray], Iterator[Place]]  # the cells of a run with its residuals over the noise


def locate(found: Fit, cells: Cells, criteria: Criteria = Criteria()) -> list[Place]:
    """The cells with significant misfit under the false-discovery rate, the most significant first."""
    return discovered(_all_cells(found, cells), criteria.false_discovery_rate)


@lru_cache(maxsize=2)  # every stage of a search reports where the same base misses
def _all_cells(found: Fit, cells: Cells) -> tuple[Place, ...]:
    """The cells of all runs of a fit."""
    places, first = [], 0
    for run in found.runs:
        last = first + len(run.data)
        places += list(cells(run, found.residuals[first:last]))
        first = last
    return tuple(places)


def discovered(places: Sequence[Place], rate: float) -> list[Place]:
    """The places that pass the false-discovery rate, the most significant first.

    They are those up to the last rank i of n places with p_i <= rate i / n.
    """
    ranked = sorted(places, key=lambda p: (p.p_value, -p.excess))
    passing = [i for i, p in enumerate(ranked, 1) if p.p_value <= rate * i / len(ranked)]
    return ranked[: max(passing, default=0)]


def place(
    run: AnyRun,
    z: np.ndarray,
    axis: str,
    low: float,
    high: float,
    unit: str,
    order: int | None = None,
    freedom: float = np.inf,
) -> Place:
    """The cell with residuals z (n,) over a noise with `freedom` degrees of freedom."""
    power, n = float(z @ z), len(z)
    # Upper tails; the distributions of scipy.stats take 50 times as long for a single number.
    chance = chdtrc(n, power) if np.isinf(freedom) else fdtrc(n, freedom, power / n)
    return Place(run.name, axis, low, high, unit, power / n - 1, float(chance), order)
