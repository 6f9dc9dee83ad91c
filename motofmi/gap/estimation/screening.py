"""Screening: a linear estimate of what each effect would gain, with the base's derivatives projected out.

    gain = |P s (s' P s)^-1 s' P r|^2,   P = 1 - J J^+

r are the base's residuals, J their derivatives by everything that is refitted, s the derivatives by the effect's
magnitudes at zero, for each set of starting values of its nonlinear parameters. This costs one simulation per set;
nothing is fitted yet.
"""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from scipy.optimize import lsq_linear

from fmus.effects import Effect
from fmus.effects.prior import LogNormalPrior
from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.estimation.fit_result import Fit, initial_guesses, with_initial_guesses
from motofmi.gap.estimation.fitting import one_step
from motofmi.gap.models.any_model import AnyModel

FAR = 30.0  # reduced chi-square of a base above which the linear screening is not reliable
STRAINED = 10.0  # standard errors between a base's parameter and its prior, with the same consequence
TOGETHER = 6  # sets of starting values that one process tries with one model


@dataclass(frozen=True)
class Signature:
    """An effect with starting values (ne,) of its parameters, and the chi-square that it could gain from there."""

    effect: type[Effect]
    gain: float
    start: np.ndarray


@dataclass(frozen=True)
class Direction:
    """The change of a fit's residuals (m, k) by an effect's k magnitudes at starting values (ne,), with the derivatives
    of the fit projected out; sizes are the indices of the magnitudes, low and high (k,) the bounds of their change."""

    effect: type[Effect]
    start: np.ndarray
    sizes: list[int]
    slopes: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def start_after(self, change: np.ndarray) -> np.ndarray:
        """The starting values with the magnitudes changed by (k,)."""
        start = self.start.copy()
        start[self.sizes] += change
        return start


def screen(found: Fit, effects: Iterable[type[Effect]], keep: int = 2) -> list[Signature]:
    """The best starting values, at most `keep`, of every effect on top of a fit; after a deadline none."""
    basis = span_of(found)
    left = found.residuals - basis @ (basis.T @ found.residuals)
    found, from_last = simulated_again(found)

    def tried(part: tuple[type[Effect], list[dict[str, float]]]) -> list[tuple[float, np.ndarray]]:
        effect, shapes = part
        if time_is_up():
            return []
        try:
            model = found.model.with_added_effects(effect, slopes_of_base=False)
        except InputError:  # it cannot be added to the effects of the fit
            return []
        signatures = []
        for shape in shapes:
            with suppress(InputError):  # the simulation diverges with these values
                if effect.prior is not None:
                    signatures += _from_prior(found, effect, effect.prior)
                    continue
                signatures.append(_signature(found, model, effect, shape, basis, left, from_last))
        return signatures

    effects = list(effects)
    parts = [
        (effect, shapes[i : i + TOGETHER])
        for effect in effects
        for shapes in [shapes_of(found, effect)]
        for i in range(0, len(shapes), TOGETHER)
    ]
    by_effect: dict[type[Effect], list[tuple[float, np.ndarray]]] = {effect: [] for effect in effects}
    for (effect, _), signatures in zip(parts, parallel_map(tried, parts, "screening effects"), strict=True):
        by_effect[effect] += signatures
    return [
        Signature(effect, *signature)
        for effect, shapes in by_effect.items()
        for signature in sorted(shapes, key=lambda signature: -signature[0])[:keep]
    ]


def shapes_of(found: Fit, effect: type[Effect]) -> list[dict[str, float]]:
    """The starting values of an effect's nonlinear parameters: all combinations of its starts."""
    largest = found.model.largest(found.runs) if effect.relative else 1.0
    first = effect.free_parameters()[0]
    grids = {
        n: [s * (largest if n in effect.relative else 1.0) for s in starts]
        for n, starts in effect.starts.items()
        if n != first
    }
    return [dict(zip(grids, point, strict=True)) for point in product(*grids.values())]


def _from_prior(found: Fit, effect: type[Effect], prior: LogNormalPrior) -> list[tuple[float, np.ndarray]]:
    """Gains and starting values of an effect that is not absent at zero: one step of Gauss and Newton from the median
    of its prior; where the base is far from the data also from the published values, with the base at its own values.
    """
    model, far = found.model.with_added_effects(effect), far_from_data(found)
    bases = [found.x, with_own_base(found)] if far else [found.x]
    order = [prior.names.index(n) for n in effect.free_parameters()]
    shared, signatures = len(found.model.names), []
    for start in (prior.median, *prior.sample) if far else (prior.median,):
        gains = []
        for base in bases:
            with suppress(InputError):
                x = np.concatenate([base[:shared], start[order], base[shared:]])
                gains.append(found.chi2 - one_step(model, found.runs, x))
        signatures += [(max(gains), start[order])] if gains else []
    return signatures


def with_own_base(found: Fit) -> np.ndarray:
    """x with the parameters of the base at the values of the component."""
    base = len(found.model.base)
    return np.concatenate([found.model.start()[:base], found.x[base:]])


def far_from_data(found: Fit) -> bool:
    """Whether a base is so far from the data, or from its priors, that linear estimates from its derivatives are
    unreliable."""
    return found.reduced > FAR or bool(np.max(np.abs(found.residuals[found.count :]), initial=0.0) > STRAINED)


def simulated_again(found: Fit) -> tuple[Fit, bool]:
    """The fit, with its own parameters in the last simulation of every run, and whether each could be simulated so."""
    again = replace(found, runs=with_initial_guesses(found.runs, initial_guesses(found.runs)))
    try:
        for index, run in enumerate(again.runs):
            again.model.simulate_again(run, again.of_run(index))
    except InputError:
        return found, False
    return again, True


def _signature(found: Fit, model: AnyModel, effect: type[Effect], shape: dict[str, float], basis: np.ndarray,
               left: np.ndarray, from_last: bool) -> tuple[float, np.ndarray]:  # fmt: skip
    """Gain and starting values of an effect for given nonlinear parameters."""
    direction = direction_of(found, model, effect, shape, basis, from_last)
    scale = np.linalg.norm(direction.slopes, axis=0) + 1e-12
    low, high = direction.low * scale, direction.high * scale
    solved = lsq_linear(direction.slopes / scale, -left, (np.minimum(low, -1e-12), np.maximum(high, 1e-12)))
    return float(left @ left - 2 * solved.cost), direction.start_after(solved.x / scale)


def direction_of(
    found: Fit, model: AnyModel, effect: type[Effect], shape: dict[str, float], basis: np.ndarray, from_last: bool
) -> Direction:
    """The direction of an effect on top of a fit, for given nonlinear parameters.

    model is the fit's with the effect; basis (m, k) are orthonormal columns that span the fit's own derivatives;
    from_last is that of `AnyModel.slopes`. Raises InputError where the model cannot be simulated.
    """
    own = effect.free_parameters()
    rows = [model.component.table[model.experiment.parameter(effect, n)] for n in own]
    start = np.array(
        [
            shape.get(n, r.start if n in effect.nonlinear_parameters() else max(r.min, 0.0))
            for n, r in zip(own, rows, strict=True)
        ],
        float,
    )
    # A magnitude that cannot be zero is singular there (a shaft without compliance): the derivative is
    # taken at its start value.
    evaluated_at = np.array(
        [
            r.start if n not in effect.nonlinear_parameters() and r.min > 0 else x
            for n, r, x in zip(own, rows, start, strict=True)
        ],
        float,
    )
    shared = len(found.model.names)
    columns = []
    for index, run in enumerate(with_initial_guesses(found.runs, initial_guesses(found.runs))):
        q = np.concatenate([found.of_run(index)[:shared], evaluated_at])
        columns.append(model.slopes(run, q, from_last)[:, shared:])
    sizes = [i for i, n in enumerate(own) if n not in effect.nonlinear_parameters()]
    slopes = np.zeros((len(basis), len(sizes)))
    slopes[: found.count] = np.concatenate(columns)[:, sizes]
    slopes -= basis @ (basis.T @ slopes)
    low, high = (np.array([getattr(rows[i], end) - start[i] for i in sizes]) for end in ("min", "max"))
    return Direction(effect, start, sizes, slopes, low, high)


def span_of(found: Fit) -> np.ndarray:
    """Orthonormal columns (m, k) that span the derivatives of a fit."""
    return np.linalg.qr(found.jacobian / (np.linalg.norm(found.jacobian, axis=0) + 1e-12))[0]
