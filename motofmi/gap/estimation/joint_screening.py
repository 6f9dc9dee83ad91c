"""Joint screening: a linear estimate of what two effects would gain together, of all pairs of a library.

    gain = max over s, t of |P r|^2 - |P (r + S_a s + S_b t)|^2,   P = 1 - J J^+

r are the residuals of a fit, J its derivatives, S_a and S_b those by the magnitudes of two effects within their bounds.
This is the best subset of size two. Forward selection, which adds the second effect to the best first one, fails where
neither effect gains alone: dry friction raises the damping at small rates, drag at large ones, and a linear damper
compensates for either.

Source: Miller, Subset Selection in Regression (2002), ch. 3.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.optimize import lsq_linear

from fmus.effects import Effect
from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.screening import Direction, direction_of, shapes_of, simulated_again, span_of

RIDGE = 1e-9  # added to the diagonal of the scaled normal equations, in which effects may be linearly dependent


@dataclass(frozen=True)
class PairSignature:
    """Two effects with the starting values of each, and the chi-square that they could gain together."""

    effects: tuple[type[Effect], type[Effect]]
    gain: float
    starts: tuple[np.ndarray, np.ndarray]

    @property
    def families(self) -> frozenset[str]:
        """The families of both effects."""
        return frozenset(effect.family for effect in self.effects)


def screen_pairs(found: Fit, effects: Sequence[type[Effect]]) -> list[PairSignature]:
    """The best starting values of every pair of effects of different families, the largest gain first.

    Effects with a prior of their own are left out, since they have no zero to start from.
    """
    basis = span_of(found)
    left = found.residuals - basis @ (basis.T @ found.residuals)
    found, from_last = simulated_again(found)

    def of_effect(effect: type[Effect]) -> list[Direction]:
        directions: list[Direction] = []
        with suppress(InputError):  # it cannot be added to the effects of the fit
            model = found.model.with_added_effects(effect, slopes_of_base=False)
            for shape in shapes_of(found, effect) if not time_is_up() else ():
                with suppress(InputError):  # the simulation diverges with these values
                    # A worker cannot return the class of an effect that was placed at an element.
                    directions.append(
                        replace(direction_of(found, model, effect, shape, basis, from_last), effect=Effect)
                    )
        return directions

    plain = [effect for effect in effects if effect.prior is None]
    of_each = parallel_map(of_effect, plain, "screening pairs")
    directions = [replace(d, effect=effect) for effect, of_one in zip(plain, of_each, strict=True) for d in of_one]
    if not directions:
        return []
    return sorted(_best_pairs(directions, left), key=lambda pair: -pair.gain)


def _best_pairs(directions: Sequence[Direction], left: np.ndarray) -> list[PairSignature]:
    """The pair with the largest gain of every two effects; left (m,) are the residuals that their directions reduce."""
    slopes = np.hstack([d.slopes for d in directions])
    scale = np.linalg.norm(slopes, axis=0) + 1e-12
    normal, gradient = (slopes.T @ slopes) / np.outer(scale, scale), slopes.T @ left / scale
    ends = np.cumsum([0] + [len(d.sizes) for d in directions])
    places = [np.arange(a, b) for a, b in pairwise(ends)]

    def gains_with(i: int) -> list[tuple[int, float, np.ndarray]]:
        """The later directions of other families, with the gain and the changes of both."""
        found = []
        for j in range(i + 1, len(directions)):
            one, two = directions[i], directions[j]
            if one.effect.family != two.effect.family:
                both = np.concatenate([places[i], places[j]])
                low, high = (
                    np.concatenate([getattr(one, end), getattr(two, end)]) * scale[both] for end in ("low", "high")
                )
                gain, change = _bounded_gain(normal[np.ix_(both, both)], gradient[both], low, high)
                found.append((j, gain, change / scale[both]))
        return found

    best: dict[tuple[type[Effect], type[Effect]], PairSignature] = {}
    for one, gains in zip(directions, parallel_map(gains_with, range(len(directions)), "screening pairs"), strict=True):
        for j, gain, change in gains:
            effects = one.effect, directions[j].effect
            if effects not in best or gain > best[effects].gain:
                first, second = np.split(change, [len(one.sizes)])
                starts = one.start_after(first), directions[j].start_after(second)
                best[effects] = PairSignature(effects, gain, starts)
    return list(best.values())


def _bounded_gain(
    normal: np.ndarray, gradient: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[float, np.ndarray]:
    """The largest decrease of x'Nx + 2 g'x below zero within bounds, and the x (k,) that reaches it."""
    root = np.linalg.cholesky(normal + RIDGE * np.eye(len(normal)))
    solved = lsq_linear(
        root.T, np.linalg.solve(root, -gradient), (np.minimum(low, -1e-12), np.maximum(high, 1e-12)), method="bvls"
    )
    return float(-(solved.x @ normal @ solved.x + 2 * gradient @ solved.x)), solved.x
