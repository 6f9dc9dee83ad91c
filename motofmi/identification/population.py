"""The population that measured components are a sample of: means, standard deviations and
correlations of their parameters.

    mean_i = 1/n sum_k p_ik,     covariance_ij = 1/(n - 1) sum_k (p_ik - mean_i) (p_jk - mean_j)

Parameters of one sign are also described by logarithms: the log-normal distribution with the same means
and standard deviations,

    s_i^2 = ln(1 + covariance_ii / mean_i^2),     m_i = ln(mean_i) - s_i^2 / 2,

and with the correlations of the logarithms of the sample. It serves as a prior of a further component's parameters.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.support.errors import InputError, unknown
from fmus.support.notebook import html, new_axes


@dataclass(frozen=True, repr=False)
class Population:
    """names (np,) of the parameters, their units, and the sample (n, np), one row for each component.

        ten = population([riders.load(f"{number}_2011") for number in range(1, 11)])
        ten.mean, ten.standard_deviation, ten.correlation
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    sample: np.ndarray

    @property
    def mean(self) -> np.ndarray:
        """(np,)."""
        return self.sample.mean(axis=0)

    @property
    def covariance(self) -> np.ndarray:
        """(np, np)."""
        return np.atleast_2d(np.cov(self.sample, rowvar=False))

    @property
    def standard_deviation(self) -> np.ndarray:
        """(np,)."""
        return self.sample.std(axis=0, ddof=1)

    @property
    def correlation(self) -> np.ndarray:
        """(np, np)."""
        return self.covariance / np.outer(self.standard_deviation, self.standard_deviation)

    @property
    def logarithmic(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean (np,) and covariance (np, np) of the logarithms. Raises InputError for a parameter that is not
        positive in all components."""
        low = [name for name, smallest in zip(self.names, self.sample.min(axis=0), strict=True) if smallest <= 0]
        if low:
            raise InputError(
                f"{', '.join(low)} is not positive in every component, so it has no logarithm; give an offset"
            )
        deviation = np.sqrt(np.log1p((self.standard_deviation / self.mean) ** 2))
        covariance = np.corrcoef(np.log(self.sample), rowvar=False) * np.outer(deviation, deviation)
        return np.log(self.mean) - np.diag(covariance) / 2, covariance

    def draws(self, count: int, seed: int = 0) -> np.ndarray:
        """Parameters (count, np) of further members, log-normal, so that none is negative. Raises
        InputError as `logarithmic`."""
        return np.exp(np.random.default_rng(seed).multivariate_normal(*self.logarithmic, count))

    def __repr__(self) -> str:
        values = ", ".join(
            f"{n} = {m:.4g} +- {s:.2g} {u}"
            for n, m, s, u in zip(self.names, self.mean, self.standard_deviation, self.units, strict=True)
        )
        return f"Population({len(self.sample)} components: {values})"

    def _repr_html_(self) -> str:
        rows = [
            (n, f"{m:.4g}", f"{s:.2g}", u)
            for n, m, s, u in zip(self.names, self.mean, self.standard_deviation, self.units, strict=True)
        ]
        return html(
            f"Population of {len(self.sample)} components",
            ("parameter", "mean", "standard deviation", "unit"),
            rows,
            self.plot,
        )

    def plot(self, axes: Any = None) -> Any:
        """Every component's parameters over the mean, on axes of matplotlib, which are returned;
        new ones unless given."""
        axes = new_axes() if axes is None else axes
        axes.plot((self.sample / self.mean).T, ".", color="black", markersize=4)
        axes.errorbar(
            range(len(self.names)),
            np.ones(len(self.names)),
            self.standard_deviation / np.abs(self.mean),
            fmt="_",
            capsize=4,
        )
        axes.set_xticks(range(len(self.names)), [name.replace("_", "\n") for name in self.names], fontsize="small")
        axes.set(ylabel="value / mean [1]")
        return axes

    def to_dataframe(self) -> Any:
        """mean, standard_deviation and unit by parameter (pandas.DataFrame); `attrs` has the correlations."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        frame = pd.DataFrame({"mean": self.mean, "standard_deviation": self.standard_deviation,
                              "unit": list(self.units)},
                             index=pd.Index(self.names, name="parameter"))  # fmt: skip
        frame.attrs["correlation"] = self.correlation.tolist()
        return frame


def population(components: Sequence[Component], parameters: Sequence[str] | None = None,
               offsets: Mapping[str, float] | None = None) -> Population:  # fmt: skip
    """The population of components of one kind, over the parameters in which they differ unless
    `parameters` names them.

    offsets are added to parameters, each in its own unit: with the inertia of the bare handlebar,
    {"added_steer_inertia": 0.125}, the parameter is the steer inertia that a rig measures. Raises InputError for fewer
    than two components, for components of different kinds, and for a parameter that they lack.
    """
    kinds = {component.title for component in components}
    if len(components) < 2 or len(kinds) > 1:
        raise InputError(
            f"a population needs two or more components of one kind, not {len(components)} "
            f"({', '.join(sorted(kinds)) or 'none'})"
        )
    values = components[0].values
    for name in (*(parameters or ()), *(offsets or ())):
        if name not in values:
            raise unknown(f"parameter of {components[0].title}", name, values)
    names = tuple(parameters or (n for n in values if any(c.values[n] != values[n] for c in components)))
    if not names:
        raise InputError("the components are the same in every parameter")
    sample = np.array([[c.values[n] + (offsets or {}).get(n, 0.0) for n in names] for c in components])
    return Population(names, tuple(components[0].table[n].unit for n in names), sample)
