"""Parameters of a model from measured FRFs: bounded nonlinear least squares with exact derivatives.

    amplitude (2008)   sum (|H_e| - |H_m|)^2
    nyquist   (2011)   sum |H_e - H_m|^2, the squared distance in the Nyquist plane
    weighted           sum |A_e - A_m|^2 / var(A_e),   A = M/a = 1/H

The last is the default: noise enters through the torque, so the apparent inertia A is what carries it
undistorted, and each band counts by its own variance. The model is always seen through the estimator's
averages (see `frf`). Parameters are searched as logarithms, so that kg.m2 and N.m/rad are alike.

A rider is never twice the same: weighted, each run is fitted by itself, and the runs are combined as random
effects x_r ~ N(x, C_r + tau^2 I), with one spread tau of the log-parameters from run to run (DerSimonian,
Laird 1986). The papers' sums take all runs together.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import least_squares, leastsq

from fmus.errors import InputError, unknown
from identification.frf import FRF
from identification.response import Response

METHODS = ("weighted", "nyquist", "amplitude")
SMALLEST = 1e-4  # of the starting value: where a parameter's logarithm ends when its lower bound is zero
TOLERANCE = 1e-11
UNDETERMINED = 1e-6  # of the largest singular value: what lies below is not information
FIRST_STEP = 0.01  # of MINPACK's trust region: longer ones jump out of the valley from far starts
SPREAD = 0.5  # of the logarithm of further starting values


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
                raise InputError(f"{row.name} is searched as a logarithm: it needs a positive start and bounds from 0 up, "
                                 f"not {start:g} in [{low:g}, {high:g}] {row.unit}")  # fmt: skip
            lower.append(max(low, SMALLEST * start))
            upper.append(high)
        return np.log(lower), np.log(upper)

    def seen(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The apparent inertia (n,) that the estimator would see of the model, and its derivatives (np, n)."""
        inertia, slope = self.model.with_derivatives(self.powers, p, inverse=True)
        if self.weights.shape[1] == 1:
            return inertia, slope
        return (np.einsum("nk,nk->n", self.weights, inertia.reshape(self.weights.shape)),
                np.einsum("nk,pnk->pn", self.weights, slope.reshape(-1, *self.weights.shape)))  # fmt: skip

    def evaluate(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Residuals (n,) and their derivatives (np, n) by the log-parameters x (np,); complex ones as real, then imaginary."""
        p = np.exp(x)
        inertia, slope = self.seen(p)
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
        """Log-parameters (np,) and half the sum of squares that one start (np,) leads to.

        MINPACK finds an optimum within the bounds fastest. Where it leaves them, it tries again from nearer to the
        model's own values; an optimum on a bound is left to the bounded search.
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
        bounded = least_squares(lambda x: at(x)[0], np.clip(x, self.lower + inside, self.upper - inside), lambda x: at(x)[1].T,
                                (self.lower, self.upper), x_scale="jac", xtol=TOLERANCE, ftol=TOLERANCE, gtol=TOLERANCE, max_nfev=200)  # fmt: skip
        return bounded.x, float(bounded.cost)


@dataclass(frozen=True)
class Identification:
    """What was identified, in the order of `names`.

    values, standard_error (np,); covariance (np, np) of the LOGARITHMS; singular_values (np,) of the Jacobian of
    all residuals over their noise by log-parameters, and `directions` (np, np), one a row; run_to_run is the spread
    of the log-parameters over the runs; residual: radius [(rad/s2)/(N.m)], phase_deg.
    reduced_chi_square is 1 when the noise explains what is left of each run.
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
    value = 1 / together.seen(np.exp(x))[0]
    residual = {"radius": float(np.mean(np.abs(np.abs(value) - np.abs(together.measured)))),
                "phase_deg": float(np.mean(np.abs(np.angle(value / together.measured, deg=True))))}  # fmt: skip
    values = np.clip(np.exp(x), *(np.array([getattr(row, side) for row in model.rows]) for side in ("min", "max")))
    found = Identification(model.parameters, tuple(row.unit for row in model.rows), values, covariance, method, residual,
                           float(np.mean(chi_squares)), singular, directions, tau, float(np.mean(agreeing)), (), tuple(frfs),
                           tuple(np.split(value, np.cumsum([len(f.frequency) for f in frfs])[:-1])))  # fmt: skip
    return replace(found, warnings=_doubts(found, together, x))


def _uncertainty(problem: Problem, x: np.ndarray) -> tuple[np.ndarray, float]:
    """Covariance (np, np) of the log-parameters of one run, and the reduced chi-square.

    Weighted, it is (J'J)^-1, larger where more than noise is left. The papers' sums do not weigh by the noise, so
    their covariance is taken from what is left itself (White's sandwich).
    """
    residuals, jacobian = problem.evaluate(x)
    noise = problem.noise()
    freedom = max(len(residuals) - len(x), 1)
    chi_square = float(np.sum((residuals / noise) ** 2) / freedom)
    left, singular, right = np.linalg.svd(jacobian.T, full_matrices=False)
    inverse = (right.T / np.maximum(singular, UNDETERMINED * singular[0])) @ left.T
    left_over = max(chi_square, 1.0) * np.ones(len(residuals)) if problem.method == "weighted" else residuals**2 * len(residuals) / freedom
    return (inverse * left_over) @ inverse.T, chi_square


def combine(runs: np.ndarray, covariances: np.ndarray, tau: float | None = None) -> tuple[np.ndarray, np.ndarray, float]:
    """Mean (np,), covariance (np, np) and spread of log-parameters of runs (n, np) with covariances (n, np, np).

    The spread is pooled over the parameters that the runs determine: what their scatter has beyond the noise.
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


def _doubts(found: Identification, problem: Problem, x: np.ndarray) -> tuple[str, ...]:
    """Which parameters lie on a bound, and which the data cannot tell."""
    doubts = [w for f in found.frfs for w in f.warnings]
    for name, at, low, high in zip(found.names, x, problem.lower, problem.upper, strict=True):
        if at - low < 1e-3 or high - at < 1e-3:
            doubts.append(f"{name} lies on its bound {np.exp(at):.4g}: its standard error means little")
    for value, direction in zip(found.singular_values, found.directions, strict=True):
        if value < 1.0:  # one standard deviation along this direction is more than a factor of e
            names = [n for n, share in zip(found.names, direction, strict=True) if abs(share) > 0.3]
            doubts.append(f"these data cannot tell {' and '.join(names)} apart" if len(names) > 1 else f"these data cannot tell {names[0]}")
    if found.agreeing_starts < 0.5:
        doubts.append(f"only {found.agreeing_starts:.0%} of the starts reach the best fit: try more")
    return tuple(doubts)


def _stacked(values: np.ndarray) -> np.ndarray:
    return np.concatenate([values.real, values.imag], axis=-1)
