"""A base fitted to its recordings in the frequency domain, for starting values that are wrong by orders of magnitude.

Two criteria, both of the component linearised at its start values, in the logarithms theta of its parameters:

    1. sum |log G(i w; theta) - log G^(i w)|^2 / var,   G^ from the local polynomial method
    2. sum |Y - G(i w; theta) U - C (I - exp(A h) / z)^-1 tau|^2,   z = exp(i w h), h the sampling interval

A wrong gain or frequency changes the first one by a constant, so that it has few minima (Sidman et al. 1991). The
second one needs no input: the transform of a sampled free motion over a finite time is that of its first and last
state, tau (Pintelon et al. 1997), which are eliminated. Both start from the component's values with time
rescaled by factors over some decades, p t^-s with the exponent s of seconds in the unit of p.

Source: Sidman, DeAngelis, Verghese, IEEE Trans. Automatic Control 36 (1991) 1065-1070; Pintelon, Schoukens,
Vandersteen, IEEE Trans. Automatic Control 42 (1997) 1717-1720.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import expm
from scipy.optimize import least_squares

from fmus.composition.imposed_motion import ImposedMotion, ImposedThroughSpring
from fmus.declaration.component import Component
from fmus.declaration.units import BASE, unit
from fmus.linear_analysis.linearisation import linearise
from motofmi.gap.estimation.local_polynomial import Response, local_polynomial_response
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.recordings.resampling import varies

DECADES = 2.0  # of the time scale, to either side
GRID = 33  # time scales at which the second criterion is evaluated
LOG_STARTS = 9  # time scales from which the first criterion is minimised
REFINED = 3  # of their results that start the second one
MOST_LINES = 600  # of a run; with more, lines are left out evenly
LEAST_ERROR = 0.02  # relative standard deviation of a response below which its weight grows no further
MOST_ERROR = 0.5  # above which a response is left out
STEP = 1e-4  # of finite differences in theta
FAR = 12.0  # largest change of a logarithm


@dataclass(frozen=True)
class _Spectra:
    """Transforms of a run: sampling interval [s], angular frequencies (lines,), inputs (lines, nu) and outputs
    (lines, ny)."""

    interval: float
    omega: np.ndarray
    inputs: np.ndarray
    outputs: np.ndarray


class FrequencyDomainProblem:
    """The component of a model with its runs as spectra; theta (np,) are the logarithms of its free parameters."""

    def __init__(self, model: Any, runs: Sequence[SampledRun]):
        experiment = runs[0].experiment
        self.component: Component = experiment.component
        self.names, self.signs, self.start = list(model.base), model.signs, model.start()[: len(model.base)]
        rows = [self.component.table[n] for n in self.names]
        self.seconds = np.array([unit(r.unit).exponents[BASE.index("s")] for r in rows], float)
        smallest, greatest = model.magnitudes
        self.low = np.maximum(np.log(np.maximum(smallest, 1e-12)), self.start - FAR)
        self.high = np.minimum(np.log(greatest), self.start + FAR)
        self.inputs = [n for n in experiment.inputs if any(varies(run.recording[n]) for run in runs)]
        self.outputs = list(experiment.outputs)
        scale = np.sqrt(np.mean([run.measured.var(axis=0) for run in runs], axis=0))
        self.runs = [_spectra(run, self.inputs, scale) for run in runs]
        self.scale = scale
        means = {n: float(np.mean([run.recording[n].mean() for run in runs])) for n in self.outputs}
        self.at = {n: mean for n, mean in means.items() if n in self.component.states}

    def responses(
        self, theta: np.ndarray, omega: np.ndarray, interval: float = 0.0
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """Responses (k, m, ny, nu) for parameter vectors (k, np), in units of the outputs, and with a sampling interval
        transients (k, m, ny, nx)."""
        values = dict(zip(self.names, (self.signs * np.exp(theta)).T, strict=True))
        system = linearise(self.component, **values, **self.at)
        k = len(theta)
        A, B, C, D = (np.broadcast_to(x, (k, *x.shape[-2:])) for x in (system.A, system.B, system.C, system.D))
        driven = [system.inputs.index(n) for n in self.inputs]
        seen = [system.outputs.index(n) for n in self.outputs]
        C, D = C[:, seen] / self.scale[:, None], D[:, seen][:, :, driven] / self.scale[:, None]
        driven_states = np.linalg.solve(_shifted(1j * omega, A), B[:, None][..., driven])
        made = C[:, None] @ driven_states + D[:, None]
        if not interval:
            return made, None
        z = np.exp(1j * omega * interval)
        sampled = _shifted(z, expm(A * interval)) / z[:, None, None]
        transient = np.linalg.solve(np.swapaxes(sampled, -1, -2), np.swapaxes(C, -1, -2)[:, None])
        return made, np.nan_to_num(np.swapaxes(transient, -1, -2))

    def of_logarithms(self, measured: Sequence[Response], theta: np.ndarray) -> np.ndarray:
        """The residuals (k, m) of the first criterion for parameter vectors (k, np)."""
        parts = []
        for each in measured:
            made = self.responses(theta, each.omega)[0]
            error = each.deviation / (np.abs(each.response) + 1e-300)
            weight = np.where(error < MOST_ERROR, 1 / np.maximum(error, LEAST_ERROR), 0.0)
            apart = weight * np.log((made + 1e-300) / (each.response + 1e-300))
            parts += [apart.real.reshape(len(theta), -1), apart.imag.reshape(len(theta), -1)]
        return np.concatenate(parts, axis=1)

    def of_spectra(self, theta: np.ndarray, free_gain: bool = False) -> np.ndarray:
        """The residuals (k, m) of the second criterion; with `free_gain` each output has a factor of its own."""
        parts = []
        for run in self.runs:
            made, transient = self.responses(theta, run.omega, run.interval)
            assert transient is not None
            k, m, ny, nx = transient.shape
            y = np.broadcast_to(run.outputs, (k, m, ny))
            driven = np.einsum("kmyu,mu->kmy", made, run.inputs)
            basis = _real(transient.reshape(k, m * ny, nx))
            target = _real((y if free_gain else y - driven).reshape(k, m * ny, 1))
            if free_gain and self.inputs:
                gains = (driven[..., None] * np.eye(ny)).reshape(k, m * ny, ny)
                basis = np.concatenate([basis, _real(gains)], axis=2)
            basis = basis / (np.linalg.norm(basis, axis=1, keepdims=True) + 1e-300)
            u, size, _ = np.linalg.svd(basis, full_matrices=False)
            u = u * (size > 1e-9 * size[:, :1])[:, None]
            parts.append((target - u @ (np.swapaxes(u, -1, -2) @ target))[..., 0])
        return np.concatenate(parts, axis=1)

    def minimised(self, residuals: Any, start: np.ndarray, loss: str = "linear") -> tuple[np.ndarray, float]:
        """The minimum (np,) of a criterion from a start, and the criterion there."""

        def slopes(theta: np.ndarray) -> np.ndarray:
            beside = residuals(theta + STEP * np.vstack([np.eye(len(theta)), -np.eye(len(theta))]))
            return (beside[: len(theta)] - beside[len(theta) :]).T / (2 * STEP)

        start = np.clip(start, self.low + 1e-9, self.high - 1e-9)
        found = least_squares(lambda theta: residuals(theta[None])[0], start, slopes, (self.low, self.high), loss=loss,
                              max_nfev=60, xtol=1e-6, ftol=1e-6)  # fmt: skip
        return found.x, float(found.cost)

    def is_alias(self, theta: np.ndarray) -> bool:
        """Whether a free motion without inputs oscillates above half the sampling rate: a slower one has the same
        samples."""
        values = dict(zip(self.names, self.signs * np.exp(theta), strict=True))
        fastest = np.max(np.abs(np.linalg.eigvals(linearise(self.component, **values, **self.at).A).imag))
        return not self.inputs and bool(fastest * max(run.interval for run in self.runs) > np.pi)

    def rescaled(self, factor: float) -> np.ndarray:
        """The start with time slower by a factor."""
        return self.start + np.log(factor) * self.seconds


def frequency_domain_start(model: Any, runs: Sequence[SampledRun]) -> np.ndarray | None:
    """The logarithms (np,) of the base's parameters that fit the runs best in the frequency domain.

    None where a motion is imposed, the component has no states, or no linearisation near its start values is finite.
    """
    if isinstance(model.component, ImposedMotion | ImposedThroughSpring) or not model.component.states:
        return None
    problem = FrequencyDomainProblem(model, runs)
    with np.errstate(all="ignore"):
        try:
            return _best(problem)
        except (np.linalg.LinAlgError, ValueError, ZeroDivisionError):  # singular, or not finite
            return None


def _best(problem: FrequencyDomainProblem) -> np.ndarray:
    measured = [
        response
        for run in problem.runs
        if problem.inputs and (response := local_polynomial_response(run.omega, run.inputs, run.outputs)) is not None
    ]
    scales = np.logspace(-DECADES, DECADES, GRID)
    rescaled = [x for x in map(problem.rescaled, scales) if not problem.is_alias(x)] or [problem.start]
    cost = [float(np.sum(problem.of_spectra(x[None], bool(measured)) ** 2)) for x in rescaled]
    starts = [rescaled[i] for i in np.argsort(cost)[:REFINED]]
    if measured:
        begun = [problem.rescaled(s) for s in np.logspace(-DECADES, DECADES, LOG_STARTS)] + starts
        ends = [problem.minimised(lambda t: problem.of_logarithms(measured, t), x, "soft_l1") for x in begun]
        starts = [x for x, _ in sorted(ends, key=lambda end: end[1])[:REFINED]]
    ends = [problem.minimised(problem.of_spectra, x) for x in starts]
    return min(ends, key=lambda end: (problem.is_alias(end[0]), end[1]))[0]


def _spectra(run: SampledRun, inputs: Sequence[str], scale: np.ndarray) -> _Spectra:
    """The transforms of the longest stretch without gaps, in the compared band."""
    first, last = max(run.intervals, key=lambda s: s[1] - s[0])
    u = np.column_stack([run.recording[n][first:last] for n in inputs] or [np.zeros((last - first, 0))])
    y = run.measured[first:last] / scale
    lines = np.arange(1, max(int(run.reduction_band / run.recording.rate * (last - first)), 16) + 1)
    lines = lines[lines < (last - first) // 2]
    lines = lines[:: max(len(lines) // MOST_LINES, 1)]
    omega = 2 * np.pi * lines * run.recording.rate / (last - first)
    U, Y = (np.fft.rfft(x - x.mean(axis=0), axis=0)[lines] / np.sqrt(last - first) for x in (u, y))
    return _Spectra(1 / run.recording.rate, omega, U, Y)


def _shifted(s: np.ndarray, A: np.ndarray) -> np.ndarray:
    """s I - A (k, m, nx, nx) for points (m,) and matrices (k, nx, nx)."""
    return s[:, None, None] * np.eye(A.shape[-1]) - A[:, None]


def _real(x: np.ndarray) -> np.ndarray:
    """Real above imaginary parts, along the second axis."""
    return np.concatenate([x.real, x.imag], axis=1)
