"""A fitted model: its parameters with their errors, what it leaves, what it costs; and which parts of its vector belong to single runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from identification.gap.models.model import AnyModel, AnyRun, AnyStand

OF_UNKNOWN = 2.0  # AIC's price: each sees only a part of one run, of which there are always as many


@dataclass(eq=False)
class Fit:
    """A fitted model. x holds [theta, e, d_1, d_2, ...]; residuals and their jacobian the priors at the end."""

    model: AnyModel
    runs: list[Any] = field(repr=False)  # AnyRun; whoever draws them knows more of them
    x: np.ndarray
    chi2: float
    residuals: np.ndarray = field(repr=False)
    jacobian: np.ndarray = field(repr=False)
    count: int  # reduced data

    @property
    def shared(self) -> np.ndarray:
        """The parameters that all runs have in common: the model's vector."""
        return self.x[: len(self.model.names)]

    @property
    def freedom(self) -> int:
        """Data and priors, less what was fitted; unknowns of a run alone (initial states) are fitted within the model."""
        return len(self.residuals) - len(self.x) - sum(self.model.unknowns(run) for run in self.runs)

    @property
    def reduced(self) -> float:
        """Chi-square per degree of freedom: 1 at the noise floor."""
        return self.chi2 / self.freedom

    @property
    def price(self) -> float:
        """What noise alone may gain: BIC's for parameters, twice what each gains on average for the unknowns of a run alone."""
        return price(self.model, self.runs)

    @property
    def bic(self) -> float:
        """Chi-square and price: the least is the likeliest."""
        return self.chi2 + self.price

    def covariance(self) -> np.ndarray:
        """Of x; what the data do not determine has a large one."""
        scale = np.linalg.norm(self.jacobian, axis=0) + 1e-12
        u = np.linalg.pinv(self.jacobian / scale, rcond=1e-9)
        return (u @ u.T) / np.outer(scale, scale)

    def of_run(self, index: int) -> np.ndarray:
        """The model's vector for one run."""
        return vector_of(self.x, self.model, index)


@dataclass(frozen=True)
class Answer:
    """What of a fit can travel between processes."""

    x: np.ndarray
    chi2: float
    residuals: np.ndarray
    jacobian: np.ndarray
    memories: list[Any]

    @classmethod
    def of(cls, found: Fit | None) -> "Answer | None":
        return None if found is None else cls(found.x, found.chi2, found.residuals, found.jacobian, memories(found.runs))

    def on(self, model: AnyModel, runs: Sequence[AnyRun]) -> Fit:
        """The fit of that model to these runs."""
        return Fit(model, remembering(runs, self.memories), self.x, self.chi2, self.residuals, self.jacobian, sum(len(run.data) for run in runs))


def price(model: AnyModel, runs: Sequence[AnyRun]) -> float:
    """What a model of these runs costs in chi-square, by its parameters and by the unknowns of single runs."""
    count = sum(len(run.data) for run in runs)
    return len(model.names) * float(np.log(count)) + OF_UNKNOWN * sum(model.unknowns(run) for run in runs)


def deviating(stand: AnyStand) -> dict[int, float]:
    """What changes from run to run, by its place in the model's vector, and by how much: parameters of the base, zeros of sensors."""
    zeros = getattr(stand, "zeros", {}).values()
    return {i: f.spread for i, f in enumerate(stand.free) if f.spread > 0} | {len(stand.free) + i: deviation for i, deviation in enumerate(zeros)}


def memories(runs: Sequence[Any]) -> list[Any]:
    """What every run keeps of where its simulations begin, as plain data; None where it keeps nothing."""
    return [getattr(run, "guess", None) for run in runs]


def remembering(runs: Sequence[Any], kept: Sequence[Any]) -> list[Any]:
    """The runs with such memories, copied: what is tried with one leaves no trace in another."""
    return [run if memory is None else run.remembering(memory) for run, memory in zip(runs, kept, strict=True)]


def vector_of(x: np.ndarray, model: AnyModel, index: int) -> np.ndarray:
    """The model's vector for one run: the common values, moved by that run's deviations."""
    moved = list(deviating(model.stand))
    shared = len(model.names)
    q = x[:shared].copy()
    q[moved] += x[shared + index * len(moved) : shared + (index + 1) * len(moved)]
    return q


def of_runs(model: AnyModel, total: int) -> tuple[np.ndarray, np.ndarray]:
    """The deviations at the end of x, run by run: their places in the model's vector (k,), and what they are known to be (k,)."""
    places = deviating(model.stand)
    runs = (total - len(model.names)) // max(len(places), 1)
    return np.tile(np.array(list(places), int), runs), np.tile(np.array(list(places.values()), float), runs)


def zeros_of(found: Fit) -> list[dict[str, tuple[float, float]]]:
    """For every run, what its sensors' zeros are off by: value and standard error by the parameter's name."""
    model, errors = found.model, np.sqrt(np.maximum(np.diag(found.covariance()), 0.0))
    places, count = of_runs(model, len(found.x))[0], len(deviating(model.stand))
    zeros: list[dict[str, tuple[float, float]]] = [{} for _ in found.runs]
    for at, place in enumerate(places):
        if place >= len(model.base):
            zeros[at // count][model.names[place]] = (float(found.x[len(model.names) + at]), float(errors[len(model.names) + at]))
    return zeros


def parameters_of(found: Fit) -> Mapping[str, tuple[float, float, str]]:
    """Value, standard error and unit by name: the base's common values, then the effects'."""
    model, errors = found.model, np.sqrt(np.maximum(np.diag(found.covariance()), 0.0))
    values = model.values(found.shared)
    scale = [abs(values[n]) for n in model.base] + [1.0] * len(model.own)  # errors of the base are those of logarithms
    return {n: (float(values[n]), float(errors[i] * scale[i]), model.component.table[n].unit) for i, n in enumerate(model.names)}
