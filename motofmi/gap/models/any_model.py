"""What estimation, screening and selection need of a run, of an experiment and of the base with some effects.

There are models for harmonics of a known motion, for eigenvalues over speed, and for samples with unknown initial
states.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from fmus.declaration.component import Component
from fmus.declaration.variables import Variable
from fmus.effects import Effect
from motofmi.gap.experiments.experiment import FreeParameter


class AnyRun(Protocol):
    """One run for estimation: data (m,) with independent errors of known standard deviation (m,), in any units."""

    @property
    def name(self) -> str: ...
    @property
    def data(self) -> np.ndarray: ...
    @property
    def deviation(self) -> np.ndarray: ...


class AnyExperiment(Protocol):
    """The free parameters of the base and their priors."""

    @property
    def free(self) -> tuple[FreeParameter, ...]: ...
    @property
    def measured_effects(self) -> Mapping[str, tuple[float, float]]: ...
    def parameter(self, effect: type[Effect], name: str) -> str:
        """The name of an effect's parameter in the component."""


class AnyModel(Protocol):
    """Base and effects for estimation.

    A parameter vector (np,) is [logarithms of the free base parameters, the effects' parameters]; `base`, `own` and
    `names` are the names of these parts and of the whole, `rows` the declarations of `own`, `sizes` the indices in
    `own` of magnitudes, in which an effect is linear. `component` declares all variables. Where derivatives are
    expensive there may be `predicted(run, q)`, which gives the first result of `reduced` alone. Where unknowns of the
    run are searched for there may be, for the trials of a fit, `simulated_once(run, q)`, near to the last q, and
    `trial(run, q, begun)`, which is `reduced` from that simulation and does not search again. Both raise InputError
    where the run cannot be simulated so.
    """

    experiment: Any  # AnyExperiment
    effects: tuple[type[Effect], ...]
    component: Component
    base: list[str]
    own: list[str]
    names: list[str]
    rows: list[Variable]
    sizes: list[int]

    @property
    def magnitudes(self) -> tuple[np.ndarray, np.ndarray]:
        """The least and the largest absolute value (nb,) of each parameter of the base."""

    def with_added_effects(self, *effects: type[Effect], slopes_of_base: bool = True) -> "AnyModel":
        """The model with further effects; without `slopes_of_base`, columns of `reduced` other than by
        magnitudes may be zero.

        Raises InputError where an effect cannot be added.
        """

    def start_afresh(self, run: Any) -> None:
        """Treat the next simulation of a run as the first one, and not as a trial of a fit."""

    def start(self, shapes: Mapping[str, float] | None = None) -> np.ndarray:
        """The vector of the component's values, with some values of effects replaced."""

    def values(self, q: np.ndarray) -> dict[str, float]:
        """All parameter values by name for a vector."""

    def reduced(self, run: Any, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The predicted data of a run (m,) and their derivatives (m, np), both over the run's standard deviation.

        Unknowns of the run alone (initial states) are eliminated here. Raises InputError where the
        run cannot be simulated.
        """

    def simulate_again(self, run: Any, q: np.ndarray) -> None:
        """Make the simulation of a run with q the last one. Raises InputError where it cannot be simulated."""

    def slopes(self, run: Any, q: np.ndarray, from_last: bool = False) -> np.ndarray:
        """The derivatives (m, np) of `reduced` alone, at the initial states that are known of the run.

        from_last says that the last simulation of the run was that of the model without the latest effects, for the same
        values. Where these effects are absent at q they do not change this motion: only their own states are simulated.
        """

    def unknowns(self, run: Any) -> int:
        """The number of unknowns of the run alone that are eliminated."""

    def largest(self, runs: Sequence[Any]) -> float:
        """The largest motion in the runs, to which the `relative` starts of effects refer."""

    def with_remaining_noise(self, run: Any, q: np.ndarray) -> Any:
        """The run with the noise that this model leaves; the run itself where its noise is known from elsewhere."""
