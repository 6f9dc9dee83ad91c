"""Parameters of a model from measured FRFs: bounded nonlinear least squares with exact derivatives.

    amplitude (2008)   sum (|H_e| - |H_m|)^2
    nyquist   (2011)   sum |H_e - H_m|^2, the squared distance in the Nyquist plane
    weighted           sum |A_e - A_m|^2 / var(A_e),   A = M/a = 1/H

The last is the default: noise enters through the torque, so the error of the apparent inertia A is proportional to
it, and each band is weighted by its own variance. The model is averaged over each band with the estimator's own
weights (see `estimators`). The search is over logarithms of the parameters, which have no units and no sign.

A rider differs from run to run: with the weighted sum each run is fitted by itself, and the runs are combined as random
effects x_r ~ N(x, C_r + tau^2 I), with one spread tau of the log-parameters from run to run (DerSimonian,
Laird 1986). The papers' sums are over all runs together.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.optimize import least_squares, leastsq

from fmus.support.errors import InputError, unknown
from fmus.support.notebook import html
from motofmi.frequency_response.figures import FITTED, draw_modulus
from motofmi.frequency_response.frf import FRF, mean_frf
from motofmi.frequency_response.response import Response

METHODS = ("weighted", "nyquist", "amplitude")
SMALLEST = 1e-4  # lower bound of a parameter relative to its start value, if its own lower bound is zero (logarithm)
TOLERANCE = 1e-11
UNDETERMINED = 1e-6  # singular value, relative to the largest, below which a direction is not identifiable
FIRST_STEP = 0.01  # of MINPACK's trust region; with longer steps fits from distant starts miss the optimum
SPREAD = 0.5  # standard deviation of the logarithm of further start values


class Problem:
    """FRFs, a model's response and a method: residuals and their derivatives by log-parameters."""

    def __init__(self, frfs: Sequence[FRF], model: Response, method: str = "weighted",
                 bounds: Mapping[str, tuple[float, float]] | None = None):  # fmt: skip
        if method not in METHODS:
            raise unknown("method", method, METHODS)
        self.frfs, self.model, self.method = tuple(frfs), model, method
        weights = np.concatenate([f.weights for f in frfs])
        needed = np.any(weights, axis=0)
        self.weights = weights[:, needed]
        self.powers = model.powers(2 * np.pi * np.concatenate([f.nodes for f in frfs])[:, needed].ravel())
        self.measured = np.concatenate([f.inertance for f in frfs])
        self.inertia = 1 / self.measured
        self.variance = np.maximum(np.concatenate([f.variance for f in frfs]), 1e-24)
        self.scale = np.sqrt(2 / self.variance)
        self.lower, self.upper = self._limits(bounds or {})
        if 2 * len(self.measured) < len(model.parameters):
            raise InputError(f"{len(self.measured)} frequencies cannot determine {len(model.parameters)} parameters")

    def _limits(self, bounds: Mapping[str, tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
        for name in bounds:
            if name not in self.model.parameters:
                raise unknown("parameter to bound", name, self.model.parameters)
        lower, upper = [], []
        for row, start in zip(self.model.rows, self.model.values, strict=True):
            low, high = bounds.get(row.name, (row.min, row.max))
            if start <= 0 or low < 0:
                raise InputError(f"{row.name} is searched as a logarithm: it needs a positive start and bounds from 0 "
                                 f"up, not {start:g} in [{low:g}, {high:g}] {row.unit}")  # fmt: skip
            lower.append(max(low, SMALLEST * start))
            upper.append(high)
        return np.log(lower), np.log(upper)

    def averaged(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The model's apparent inertia (n,), averaged with the estimator's weights, and its derivatives (np, n)."""
        inertia, slope = self.model.with_derivatives(self.powers, p, inverse=True)
        if self.weights.shape[1] == 1:
            return inertia, slope
        return (np.einsum("nk,nk->n", self.weights, inertia.reshape(self.weights.shape)),
                np.einsum("nk,pnk->pn", self.weights, slope.reshape(-1, *self.weights.shape)))  # fmt: skip

    def evaluate(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals (n,) and their derivatives (np, n) by the log-parameters x (np,); complex ones as
        real, then imaginary."""
        p = np.exp(x)
        inertia, slope = self.averaged(p)
        slope *= p[:, None]
        if self.method == "weighted":
            return _stacked((inertia - self.inertia) * self.scale), _stacked(slope * self.scale)
        value = 1 / inertia
        slope *= -(value**2)
        if self.method == "nyquist":
            return _stacked(value - self.measured), _stacked(slope)
        return np.abs(value) - np.abs(self.measured), np.real(value.conj() / np.abs(value) * slope)

    def noise(self) -> np.ndarray:
        """The standard deviation that each residual has by the estimator's own variance."""
        if self.method == "weighted":
            return np.ones(2 * len(self.measured))
        each = np.abs(self.measured) ** 2 * np.sqrt(self.variance / 2)
        return np.tile(each, 2) if self.method == "nyquist" else each

    def solve(self, x: np.ndarray) -> tuple[np.ndarray, float]:
        """Log-parameters (np,) and half the sum of squares at the optimum reached from one start (np,).

        MINPACK's unbounded search is the fastest. If it leaves the bounds, it is repeated from a start nearer to the
        model's own values; an optimum on a bound is found by the bounded search.
        """
        last: dict[bytes, tuple] = {}

        def at(x):  # residuals and derivatives together, once per point
            key = x.tobytes()
            if key not in last:
                last.clear()
                last[key] = self.evaluate(np.minimum(np.maximum(x, self.lower), self.upper))
            return last[key]

        own = np.log(self.model.values)
        for start in (x, (x + own) / 2, own):
            free, _, found, _, status = leastsq(lambda x: at(x)[0], start, (), lambda x: at(x)[1], True, True,
                                                xtol=TOLERANCE, ftol=TOLERANCE, factor=FIRST_STEP)  # fmt: skip
            if status in (1, 2, 3, 4) and np.all((free >= self.lower) & (free <= self.upper)):
                return free, float(found["fvec"] @ found["fvec"]) / 2
        inside = np.minimum(1e-6, (self.upper - self.lower) / 4)
        bounded = least_squares(lambda x: at(x)[0], np.clip(x, self.lower + inside, self.upper - inside),
                                lambda x: at(x)[1].T, (self.lower, self.upper), x_scale="jac", xtol=TOLERANCE,
                                ftol=TOLERANCE, gtol=TOLERANCE, max_nfev=200)  # fmt: skip
        return bounded.x, float(bounded.cost)


@dataclass(frozen=True, repr=False)
class Identification:
    """Identified parameters, in the order of `names`.

    values, standard_error (np,); covariance (np, np) of the LOGARITHMS; singular_values (np,) of the Jacobian of
    all residuals over their noise by log-parameters, and `directions` (np, np), one a row; run_to_run is the spread
    of the log-parameters over the runs; residual: radius [(rad/s2)/(N.m)], phase_deg.
    reduced_chi_square is 1 when the residuals of each run are consistent with the noise.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray
    covariance: np.ndarray
    method: str
    residual: dict[str, float]
    reduced_chi_square: float
    singular_values: np.ndarray
    directions: np.ndarray
    run_to_run: float
    agreeing_starts: float
    warnings: tuple[str, ...] = ()
    frfs: tuple[FRF, ...] = field(default=(), repr=False)
    fitted: tuple[np.ndarray, ...] = field(default=(), repr=False)

    @property
    def standard_error(self) -> np.ndarray:
        return self.values * np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> np.ndarray:
        deviation = np.sqrt(np.diag(self.covariance))
        return self.covariance / np.outer(deviation, deviation)

    def draws(self, count: int, seed: int = 0) -> np.ndarray:
        """Parameter vectors (count, np) from the fitted covariance, log-normal, so that none is negative."""
        normal = np.random.default_rng(seed).multivariate_normal(np.zeros(len(self.values)), self.covariance, count)
        return self.values * np.exp(normal)

    def __getitem__(self, name: str) -> float:
        """The value of a parameter by its name, in the unit of `units`. Raises InputError with the valid
        names for any other."""
        if name not in self.names:
            raise unknown("parameter", name, self.names)
        return float(self.values[self.names.index(name)])

    def __repr__(self) -> str:
        values = ", ".join(
            f"{n} = {v:.4g} +- {e:.2g} {unit}"
            for n, v, e, unit in zip(self.names, self.values, self.standard_error, self.units, strict=True)
        )
        return f"Identification({self.method}, reduced chi-square {self.reduced_chi_square:.3g}: {values})"

    def _repr_html_(self) -> str:
        rows = [
            (n, f"{v:.5g}", f"{e:.2g}", unit)
            for n, v, e, unit in zip(self.names, self.values, self.standard_error, self.units, strict=True)
        ]
        text = (
            f"Fit ({self.method}) to {', '.join(f.name for f in self.frfs)}; reduced chi-square "
            f"{self.reduced_chi_square:.3g}"
        )
        return html(
            ". ".join([text, *self.warnings]),
            ("parameter", "value", "standard error", "unit"),
            rows,
            self._draw_modulus,
        )

    def plot(self, axes: Any = None) -> Any:
        """Modulus above phase, the mean of the runs and the fit to each: two axes of matplotlib, which are returned;
        new ones unless given."""
        axes = mean_frf(self.frfs).plot(axes)
        for frf, value in zip(self.frfs, self.fitted, strict=True):
            axes[0].plot(frf.frequency, np.abs(value), color=FITTED, linewidth=1)
            axes[1].plot(frf.frequency, np.degrees(np.angle(value)), color=FITTED, linewidth=1)
        return axes

    def _draw_modulus(self, axes: Any) -> None:
        draw_modulus(axes, mean_frf(self.frfs))
        for frf, value in zip(self.frfs, self.fitted, strict=True):
            axes.plot(frf.frequency, np.abs(value), color=FITTED, linewidth=1)

    def to_dataframe(self) -> Any:
        """The parameters by name: value, standard_error, unit (pandas.DataFrame)."""
        import pandas as pd  # noqa: PLC0415 - imported on use

        return pd.DataFrame(
            {"value": self.values, "standard_error": self.standard_error, "unit": list(self.units)},
            index=pd.Index(self.names, name="parameter"),
        )


def identify(frfs: Sequence[FRF], model: Response, method: str = "weighted",
             bounds: Mapping[str, tuple[float, float]] | None = None, starts: int = 4, seed: int = 0,
             run_to_run: float | None = None) -> Identification:  # fmt: skip
    """The parameters of `model` that fit the FRFs best, from its own values and further random starts.

    run_to_run is the spread of the log-parameters from run to run: estimated from two or more runs where none is
    given, and 0 for one run, whose standard errors then are those of that run's rider.
    Raises InputError for an unknown method or bound, and for too few frequencies.
    """
    first = np.log(model.values)
    spread = SPREAD * np.random.default_rng(seed).standard_normal((starts, len(first)))
    spread[0] = 0.0
    runs, covariances, agreeing, chi_squares = [], [], [], []
    for group in [[frf] for frf in frfs] if method == "weighted" else [frfs]:
        problem = Problem(group, model, method, bounds)
        tries = [problem.solve(first + shift) for shift in spread]
        best, cost = min(tries, key=lambda found: found[1])
        agreeing.append(np.mean([other <= cost * (1 + 1e-4) + 1e-18 for _, other in tries]))
        covariance, chi_square = _uncertainty(problem, best)
        runs.append(best)
        covariances.append(covariance)
        chi_squares.append(chi_square)
    x, covariance, tau = combine(np.array(runs), np.array(covariances), run_to_run)
    together = Problem(frfs, model, method, bounds)
    _, singular, directions = np.linalg.svd((together.evaluate(x)[1] / together.noise()).T, full_matrices=False)
    value = 1 / together.averaged(np.exp(x))[0]
    residual = {"radius": float(np.mean(np.abs(np.abs(value) - np.abs(together.measured)))),
                "phase_deg": float(np.mean(np.abs(np.angle(value / together.measured, deg=True))))}  # fmt: skip
    values = np.clip(np.exp(x), *(np.array([getattr(row, side) for row in model.rows]) for side in ("min", "max")))
    ends = np.cumsum([len(f.frequency) for f in frfs])[:-1]
    found = Identification(model.parameters, tuple(row.unit for row in model.rows), values, covariance, method,
                           residual, float(np.mean(chi_squares)), singular, directions, tau, float(np.mean(agreeing)),
                           (), tuple(frfs), tuple(np.split(value, ends)))  # fmt: skip
    return replace(found, warnings=_warnings(found, together, x))


def _uncertainty(problem: Problem, x: np.ndarray) -> tuple[np.ndarray, float]:
    """Covariance (np, np) of the log-parameters of one run, and the reduced chi-square.

    Weighted, it is (J'J)^-1, times the reduced chi-square where that exceeds 1. The papers' sums do not weigh by the
    noise, so their covariance follows from the residuals (White's sandwich estimator).
    """
    residuals, jacobian = problem.evaluate(x)
    noise = problem.noise()
    freedom = max(len(residuals) - len(x), 1)
    chi_square = float(np.sum((residuals / noise) ** 2) / freedom)
    left, singular, right = np.linalg.svd(jacobian.T, full_matrices=False)
    inverse = (right.T / np.maximum(singular, UNDETERMINED * singular[0])) @ left.T
    left_over = (
        max(chi_square, 1.0) * np.ones(len(residuals))
        if problem.method == "weighted"
        else residuals**2 * len(residuals) / freedom
    )
    return (inverse * left_over) @ inverse.T, chi_square


def combine(
    runs: np.ndarray, covariances: np.ndarray, tau: float | None = None
) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean (np,), covariance (np, np) and spread of log-parameters of runs (n, np) with covariances (n, np, np).

    The spread is pooled over the parameters that the runs determine: their scatter in excess of the noise.
    """
    count, size = runs.shape
    if tau is None:
        noise = np.mean(np.diagonal(covariances, axis1=1, axis2=2), axis=0)
        excess = np.var(runs, axis=0, ddof=1) - noise if count > 1 else np.zeros(size)
        trust = 1 / (noise + 1e-3) ** 2
        tau = float(np.sqrt(max(0.0, np.sum(trust * excess) / np.sum(trust))))
    if count == 1:
        return runs[0], covariances[0] + tau**2 * np.eye(size), tau
    weights = np.linalg.inv(covariances + tau**2 * np.eye(size))
    covariance = np.linalg.inv(weights.sum(axis=0))
    return covariance @ np.einsum("rij,rj->i", weights, runs), covariance, tau


def _warnings(found: Identification, problem: Problem, x: np.ndarray) -> tuple[str, ...]:
    """Warnings of the FRFs, parameters on a bound and parameters that are not identifiable."""
    warnings = [w for f in found.frfs for w in f.warnings]
    for name, at, low, high in zip(found.names, x, problem.lower, problem.upper, strict=True):
        if at - low < 1e-3 or high - at < 1e-3:
            warnings.append(f"{name} lies on its bound {np.exp(at):.4g}: its standard error is not meaningful")
    for value, direction in zip(found.singular_values, found.directions, strict=True):
        if value < 1.0:  # one standard deviation along this direction is more than a factor of e
            names = [n for n, share in zip(found.names, direction, strict=True) if abs(share) > 0.3]
            which = "are identifiable only in combination" if len(names) > 1 else "is not identifiable"
            warnings.append(f"{' and '.join(names)} {which} from these data")
    if found.agreeing_starts < 0.5:
        warnings.append(f"only {found.agreeing_starts:.0%} of the starts reach the best fit: try more")
    return tuple(warnings)


def _stacked(values: np.ndarray) -> np.ndarray:
    return np.concatenate([values.real, values.imag], axis=-1)
