"""A fitted model: parameters with standard errors, residuals, penalty, and the parts of its vector that
belong to single runs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.models.any_model import AnyExperiment, AnyModel, AnyRun

T = TypeVar("T")
OF_UNKNOWN = 2.0  # AIC's penalty of an unknown of a single run: the data behind it do not grow with the number of runs


@dataclass(eq=False)
class Fit:
    """A fitted model. x holds [theta, e, d_1, d_2, ...]; residuals and jacobian include the priors as last rows."""

    model: AnyModel
    runs: list[Any] = field(repr=False)  # AnyRun; reports use further attributes of the runs
    x: np.ndarray
    chi2: float
    residuals: np.ndarray = field(repr=False)
    jacobian: np.ndarray = field(repr=False)
    count: int  # reduced data
    sandwich: np.ndarray | None = field(default=None, repr=False)  # a covariance that includes errors of the model

    def __repr__(self) -> str:
        effects = ", ".join(f"{e.family} ({e.form})" for e in self.model.effects) or "base alone"
        return f"Fit({effects}, {len(self.runs)} runs, {self.count} data, reduced chi-square {self.reduced:.3g})"

    @property
    def shared(self) -> np.ndarray:
        """The parameters common to all runs: the model's vector."""
        return self.x[: len(self.model.names)]

    @property
    def freedom(self) -> int:
        """Degrees of freedom: data and priors minus fitted numbers, with the unknowns of single runs
        (initial states) included."""
        return len(self.residuals) - len(self.x) - sum(self.model.unknowns(run) for run in self.runs)

    @property
    def reduced(self) -> float:
        """Chi-square per degree of freedom, 1 at the noise floor."""
        return self.chi2 / self.freedom

    @property
    def penalty(self) -> float:
        """The penalty of the model: that of BIC for effective parameters, that of AIC for unknowns of single runs."""
        return penalty(self.model, self.runs) - sum(map(self.spared, self.model.effects))

    @property
    def bic(self) -> float:
        """Chi-square plus penalty; the model with the least is the most probable."""
        return self.chi2 + self.penalty

    def covariance(self) -> np.ndarray:
        """The covariance of x: the one that includes errors of the model, where it was computed."""
        return self.covariance_by_model() if self.sandwich is None else self.sandwich

    def covariance_by_model(self) -> np.ndarray:
        """The covariance (J'J)^-1 of x, where the model is true and the noise known."""
        scale = np.linalg.norm(self.jacobian, axis=0) + 1e-12
        u = np.linalg.pinv(self.jacobian / scale, rcond=1e-9)
        return (u @ u.T) / np.outer(scale, scale)

    def runs_with_remaining_noise(self) -> list[Any]:
        """The runs with the noise that is estimated from the residuals. Raises InputError where a run cannot be
        simulated again."""
        return [self.model.with_remaining_noise(run, self.of_run(i)) for i, run in enumerate(self.runs)]

    def with_scaled_noise(self, factor: float) -> "Fit":
        """The fit, with the same parameters, on its runs with the variance of their noise multiplied by a factor."""
        size = np.ones(len(self.residuals))
        size[: self.count] = factor**-0.5  # priors do not depend on the noise
        residuals = size * self.residuals
        return replace(
            self,
            runs=[run.with_scaled_noise(factor) for run in self.runs],
            chi2=float(residuals @ residuals),
            residuals=residuals,
            jacobian=size[:, None] * self.jacobian,
        )

    def effective_parameters(self, effect: type[Effect]) -> float:
        """The number of an effect's parameters that the data determine: k without a prior, and with one

            k_eff = tr[I (I + P)^-1] = k - tr(P C)

        I is the information of the data with the base projected out, P that of the prior and C the covariance of the
        fit without errors of the model: the trace of the hat matrix of these parameters.

        Source: Ye, J. Am. Statist. Assoc. 93 (1998) 120-131; Spiegelhalter, Best, Carlin, van der Linde, J. R. Statist.
        Soc. B 64 (2002) 583-639, p_D of the normal linear model.
        """
        own = effect.free_parameters()
        if effect.prior is None:
            return float(len(own))
        places = places_of(self, effect, effect.prior.names)
        slopes = effect.prior.slopes(self.x[places])
        prior_information = slopes.T @ slopes
        return len(own) - float(np.sum(prior_information * self.covariance_by_model()[np.ix_(places, places)]))

    def spared(self, effect: type[Effect]) -> float:
        """By how much the penalty is smaller, as the prior determines parameters of an effect of this fit."""
        return (len(effect.free_parameters()) - self.effective_parameters(effect)) * float(np.log(self.count))

    def of_run(self, index: int) -> np.ndarray:
        """The model's vector for one run."""
        return vector_of(self.x, self.model, index)


@dataclass(frozen=True)
class PortableFit:
    """The part of a fit that is sent between processes."""

    x: np.ndarray
    chi2: float
    residuals: np.ndarray
    jacobian: np.ndarray
    initial_guesses: list[Any]

    @classmethod
    def of(cls, found: Fit | None) -> "PortableFit | None":
        return (
            None
            if found is None
            else cls(found.x, found.chi2, found.residuals, found.jacobian, initial_guesses(found.runs))
        )

    def on(self, model: AnyModel, runs: Sequence[AnyRun]) -> Fit:
        """The fit of that model to these runs."""
        return Fit(
            model,
            with_initial_guesses(runs, self.initial_guesses),
            self.x,
            self.chi2,
            self.residuals,
            self.jacobian,
            sum(len(run.data) for run in runs),
        )


def penalty(model: AnyModel, runs: Sequence[AnyRun]) -> float:
    """The penalty of a model of these runs in chi-square, for all its parameters and for the unknowns of single
    runs."""
    count = sum(len(run.data) for run in runs)
    return len(model.names) * float(np.log(count)) + OF_UNKNOWN * sum(model.unknowns(run) for run in runs)


def run_to_run_deviations(experiment: AnyExperiment) -> dict[int, float]:
    """The standard deviations of base parameters and sensor offsets that differ between runs, by their index in the
    model's vector."""
    offsets = getattr(experiment, "sensor_offsets", {}).values()
    return {i: f.spread for i, f in enumerate(experiment.free) if f.spread > 0} | {
        len(experiment.free) + i: deviation for i, deviation in enumerate(offsets)
    }


def initial_guesses(runs: Sequence[Any]) -> list[Any]:
    """The initial guesses of each run's simulations as plain data; None for runs without them."""
    return [getattr(run, "guess", None) for run in runs]


def with_initial_guesses(runs: Sequence[Any], kept: Sequence[Any]) -> list[Any]:
    """The runs with copies of such guesses, so that fits do not change each other's runs."""
    return [run if guess is None else run.with_initial_guesses(guess) for run, guess in zip(runs, kept, strict=True)]


def or_from_recorded_motion(simulated: Callable[[Sequence[Any]], T], runs: Sequence[Any]) -> T:
    """simulated(runs), or where a simulation diverges from the states that are known, from the recorded motion.

    From the states of a base that misses most of the motion, simulations of other models may diverge. Raises InputError
    where a simulation from the recorded motion diverges, too.
    """
    try:
        return simulated(runs)
    except InputError:
        return simulated(with_initial_guesses(runs, [{} for _ in runs]))


def vector_of(x: np.ndarray, model: AnyModel, index: int) -> np.ndarray:
    """The model's vector for one run: the common values plus that run's deviations."""
    deviating = list(run_to_run_deviations(model.experiment))
    shared = len(model.names)
    q = x[:shared].copy()
    q[deviating] += x[shared + index * len(deviating) : shared + (index + 1) * len(deviating)]
    return q


def deviations_of_runs(model: AnyModel, total: int) -> tuple[np.ndarray, np.ndarray]:
    """The deviations at the end of x, run by run: their indices in the model's vector (k,) and
    standard deviations (k,)."""
    places = run_to_run_deviations(model.experiment)
    runs = (total - len(model.names)) // max(len(places), 1)
    return np.tile(np.array(list(places), int), runs), np.tile(np.array(list(places.values()), float), runs)


def sensor_offsets_of(found: Fit) -> list[dict[str, tuple[float, float]]]:
    """The sensor offsets of every run, that of all runs plus its own: value and standard error by the parameter's name."""
    model = found.model
    places, count = deviations_of_runs(model, len(found.x))[0], len(run_to_run_deviations(model.experiment))
    own = [(at // count, place, len(model.names) + at) for at, place in enumerate(places) if place >= len(model.base)]
    sums = np.zeros((len(own), len(found.x)))
    for row, (_, place, at) in zip(sums, own, strict=True):
        row[[place, at]] = 1.0
    errors = standard_errors(sums @ found.covariance() @ sums.T)
    offsets: list[dict[str, tuple[float, float]]] = [{} for _ in found.runs]
    for (run, place, _), value, error in zip(own, sums @ found.x, errors, strict=True):
        offsets[run][model.names[place]] = float(value), float(error)
    return offsets


def standard_errors(covariance: np.ndarray) -> np.ndarray:
    """The standard errors (n,) of a covariance (n, n); infinite for a parameter without influence on the data, whose
    variance is zero in a pseudo-inverse."""
    variance = np.maximum(np.diag(covariance), 0.0)
    return np.where(variance > 0, np.sqrt(variance), np.inf)


def places_of(found: Fit, effect: type[Effect], names: Sequence[str]) -> list[int]:
    """The indices in x of these parameters of an effect."""
    return [found.model.names.index(found.model.experiment.parameter(effect, n)) for n in names]


def parameters_of_effect(found: Fit, effect: type[Effect]) -> dict[str, tuple[float, float, str]]:
    """Value, standard error and unit of an effect's fitted parameters, by their short names."""
    known = parameters_of(found)
    return {n: known[found.model.experiment.parameter(effect, n)] for n in effect.free_parameters()}


def parameters_of(found: Fit, errors: np.ndarray | None = None) -> Mapping[str, tuple[float, float, str]]:
    """Value, standard error and unit by name: the base's common values, then the effects'.

    errors (parameters,) are the standard errors of x (default: those of the fit's covariance).
    """
    model, errors = found.model, standard_errors(found.covariance()) if errors is None else errors
    values = model.values(found.shared)
    scale = [abs(values[n]) for n in model.base] + [1.0] * len(model.own)  # errors of the base are those of logarithms
    return {
        n: (float(values[n]), float(errors[i] * scale[i]), model.component.table[n].unit)
        for i, n in enumerate(model.names)
    }


def undetermined(parameters: Mapping[str, tuple[float, float, str]], errors: float) -> list[str]:
    """The parameters that are within this many standard errors of zero, from value, standard error and unit."""
    return [n for n, (value, error, _) in parameters.items() if abs(value) < errors * error]
