"""Which places of a run's residuals are more than noise, under a stated false-discovery rate.

    (z'z / n) / 1  ~  F(n, v)

The n residuals z of a cell, over the noise, are noise themselves unless the model misses there; v is on how many numbers
the noise is known (chi-square where it is given). Of all cells of all runs those are kept whose p-values pass the rate.

Source: Benjamini, Hochberg, J. R. Statist. Soc. B 57 (1995) 289-300.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import chi2, f, false_discovery_control

from identification.gap.models.model import AnyRun
from identification.gap.naming.fitted import Fit

FALSE_DISCOVERIES = 0.01


@dataclass(frozen=True)
class Place:
    """A cell along an axis, of one harmonic order or of all, with the reduced chi-square minus 1 there and the chance of as much from noise alone."""

    run: str
    axis: str
    start: float
    end: float
    unit: str
    excess: float
    p_value: float
    order: int | None = None


Cells = Callable[[Any, np.ndarray], Iterator[Place]]  # of a run and its residuals over the noise


def locate(found: Fit, cells: Cells, rate: float = FALSE_DISCOVERIES) -> list[Place]:
    """The cells in which the fit misses the data, the clearest first."""
    places, first = [], 0
    for run in found.runs:
        last = first + len(run.data)
        places += list(cells(run, found.residuals[first:last]))
        first = last
    return discovered(places, rate)


def discovered(places: list[Place], rate: float) -> list[Place]:
    """Those of all places that pass the false-discovery rate, the clearest first."""
    ranked = sorted(places, key=lambda p: (p.p_value, -p.excess))
    adjusted = false_discovery_control([p.p_value for p in ranked]) if ranked else []
    return [p for p, least_rate in zip(ranked, adjusted, strict=True) if least_rate <= rate]


def place(run: AnyRun, z: np.ndarray, axis: str, low: float, high: float, unit: str, order: int | None = None, freedom: float = np.inf) -> Place:
    """The cell with residuals z (n,) over a noise that rests on `freedom` numbers."""
    power, n = float(z @ z), len(z)
    chance = chi2.sf(power, n) if np.isinf(freedom) else f.sf(power / n, n, freedom)
    return Place(run.name, axis, low, high, unit, power / n - 1, float(chance), order)
