"""Distributions of parameters, and designs of their members: at random, as a Latin hypercube, or a Sobol sequence.

A log-normal distribution is p = exp(m + L z) - offset with z standard normal and L L^T the covariance of the
logarithms; a design gives points u of the unit cube and z = Phi^-1(u), so that every design serves every distribution.

Latin hypercube: McKay, Beckman, Conover, Technometrics 21 (1979); Sobol sequence with Owen's scrambling:
Owen, J. Complexity 14 (1998), as in `scipy.stats.qmc`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.special import ndtri
from scipy.stats import qmc

from fmus.declaration.component import Component
from fmus.support.errors import InputError, unknown
from motofmi.identification.population import Population

DESIGNS = ("sobol", "latin_hypercube", "random", "members")
INSIDE = 2.0**-40  # distance of a design's points from the faces of the unit cube, where Phi^-1 is infinite


class Distribution(Protocol):
    """names (np,) and units of parameters, and their values (n, np) at points (n, np) of the unit cube."""

    @property
    def names(self) -> tuple[str, ...]: ...

    @property
    def units(self) -> tuple[str, ...]: ...

    def at(self, points: np.ndarray) -> np.ndarray: ...


@dataclass(frozen=True)
class LogNormal:
    """Log-normal parameters: mean (np,) and covariance (np, np) of the logarithms of value + offset. members (n, np)
    is the sample that it was estimated from, if there is one."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    mean: np.ndarray
    covariance: np.ndarray
    offset: np.ndarray
    members: np.ndarray | None = None

    def at(self, points: np.ndarray) -> np.ndarray:
        """The values (n, np) at points of the unit cube."""
        eigenvalues, vectors = np.linalg.eigh(self.covariance)  # of a small sample it is singular
        root = vectors * np.sqrt(eigenvalues.clip(0.0))
        normal = ndtri(points.clip(INSIDE, 1.0 - INSIDE))
        return np.exp(self.mean + normal @ root.T) - self.offset


@dataclass(frozen=True)
class Uniform:
    """One parameter between two values."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    low: float
    high: float

    def at(self, points: np.ndarray) -> np.ndarray:
        """The values (n, 1) at points of the unit cube."""
        return self.low + (self.high - self.low) * points


def of_sample(found: Population, offsets: np.ndarray) -> LogNormal:
    """The log-normal distribution of a population whose sample includes the offsets (np,)."""
    mean, covariance = found.logarithmic
    return LogNormal(found.names, found.units, mean, covariance, offsets, found.sample - offsets)


def of_component(component: Component, offsets: dict[str, float]) -> LogNormal:
    """The log-normal distribution of a component with standard errors and correlations, as of a measured rider.

    With the relative error e = error / (value + offset), the logarithms have the variance ln(1 + e^2) and the mean
    ln(value + offset) - ln(1 + e^2) / 2. Raises InputError for a component without standard errors.
    """
    names = tuple(component.standard_error)
    if not names:
        raise InputError(f"{component.name} has no standard errors, so it is no population: give each parameter a "
                         "standard_error and correlations, as motofmi identify --out writes them")  # fmt: skip
    value = np.array([component.values[n] + offsets.get(n, 0.0) for n in names])
    if (value <= 0).any():
        raise InputError(f"{names[int((value <= 0).argmax())]} of {component.name} is not positive, so it has no "
                         "logarithm")  # fmt: skip
    error = np.array([component.standard_error[n] for n in names])
    variance = np.log1p((error / value) ** 2)
    correlation = np.eye(len(names))
    for i, one in enumerate(names):
        for j, other in enumerate(names[:i]):
            given = component.correlation.get(one, {}).get(other, component.correlation.get(other, {}).get(one, 0.0))
            correlation[i, j] = correlation[j, i] = given
    return LogNormal(names, tuple(component.table[n].unit for n in names), np.log(value) - variance / 2,
                     correlation * np.sqrt(np.outer(variance, variance)),
                     np.array([offsets.get(n, 0.0) for n in names]))  # fmt: skip


def drawn(distributions: Sequence[Distribution], count: int, design: str, seed: int) -> list[np.ndarray]:
    """The values (count, np) of each distribution at the points of one design.

    The design `members` gives the sample of a distribution itself. Raises InputError for an unknown design, and for
    `members` of a distribution without them.
    """
    if design not in DESIGNS:
        raise unknown("design", design, DESIGNS)
    if design == "members":
        found = [getattr(each, "members", None) for each in distributions]
        if len(found) != 1 or found[0] is None:
            raise InputError("the design members needs one population of published riders, as in rider~riders_2011")
        return [found[0]]
    if count < 1:
        raise InputError(f"count = {count}: a population needs one member or more")
    sizes = [len(each.names) for each in distributions]
    points = _points(sum(sizes), count, design, seed)
    ends = np.cumsum(sizes)
    return [each.at(points[:, end - size : end]) for each, size, end in zip(distributions, sizes, ends, strict=True)]


def _points(dimensions: int, count: int, design: str, seed: int) -> np.ndarray:
    """Points (count, dimensions) of the unit cube."""
    random = np.random.default_rng(seed)
    if design == "random":
        return random.random((count, dimensions))
    if design == "latin_hypercube":
        return qmc.LatinHypercube(dimensions, rng=random).random(count)
    return qmc.Sobol(dimensions, rng=random).random_base2(max(int(np.ceil(np.log2(count))), 0))[:count]
