r"""The comparison on blocks for data in which there is nothing to name, at the cost of linear algebra.

    y* = y(theta) + e*,   e* = the base's real residuals, cut into blocks, permuted, each with a random sign

y(theta) is the simulated base with its fitted parameters, so the base is the truth of the motion. The blocks are as
long as the residuals are correlated; their order starts at a random sample. e* therefore has the amplitudes and the
correlation of the real residuals, and its mean, whatever the motion is, is zero: no effect explains it. Fitted and
validation runs are made in the same way, each from its own residuals. Initial states and sensor offsets are estimated
anew from y* by simulation. Base and effects are refitted by linearisation at the truth, where an effect is zero:

    r = r* + J dtheta + S_e e,   least squares over the fitted runs, e within its bounds

J and S_e are simulated once for a recording, S_e for every set of starting values of an effect's nonlinear parameters,
of which the one that gains most is kept. On validation runs dtheta and e are those of the fitted runs. What follows is
that of the workflow: blocks, losses without a block, standard errors, forms, and the decision.

Source: permutation of blocks: Carlstein, Ann. Statist. 14 (1986) 1171-1179; signs: Liu, Ann. Statist. 16 (1988)
1696-1708.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
from scipy.optimize import lsq_linear

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.comparison.block_losses import (
    SHORTEST_BLOCK,
    correlation_length,
    left_out_mean_squares,
    mean_squares,
    partition,
)
from motofmi.gap.comparison.closable import flexible_mean_square
from motofmi.gap.comparison.compared_model import CommonBlocks, ComparedModel
from motofmi.gap.comparison.outcome import Outcome, outcome
from motofmi.gap.comparison.pair_search import JOINT_PAIRS, SECOND_EFFECTS
from motofmi.gap.comparison.residuals import output_scale, time_residuals
from motofmi.gap.comparison.search import LEADING_FAMILIES, clearly_behind
from motofmi.gap.comparison.simplest_form import one_per_families
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.fit_result import Fit, standard_errors
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.screening import shapes_of
from motofmi.gap.preprocessing.sampled_run import SampledRun


@dataclass(frozen=True)
class Slopes:
    """An effect at zero magnitude: its values x (own,), which of them are magnitudes, the bounds of these, and the
    derivatives by them of the residuals of the fitted (m, k) and of the validation runs (m', k)."""

    effect: type[Effect]
    x: np.ndarray
    sizes: np.ndarray
    low: np.ndarray
    high: np.ndarray
    fitted: np.ndarray
    validation: np.ndarray


@dataclass(frozen=True)
class Null:
    """A base as the truth of fitted and of validation runs, the residuals that real data left of it, by run and in
    physical units, and the effects that the library offers."""

    fitted: Fit
    validation: Fit
    left: list[np.ndarray]
    left_validation: list[np.ndarray]
    effects: list[Slopes]

    @cached_property
    def basis(self) -> np.ndarray:
        """An orthonormal basis (m, p) of the derivatives by the base's parameters."""
        return np.linalg.qr(self.fitted.jacobian / (np.linalg.norm(self.fitted.jacobian, axis=0) + 1e-12))[0]

    @cached_property
    def projected(self) -> list[np.ndarray]:
        """The derivatives of each effect without what the base's parameters take up."""
        return [s.fitted - self.basis @ (self.basis.T @ s.fitted) for s in self.effects]


def null_of(base: Fit, validation: Fit, library: Sequence[type[Effect]]) -> Null:
    """The null hypothesis of a fitted base; validation is the same base on validation runs."""
    truths, lefts = [], []
    for found in (base, validation):
        left = [run * output_scale(found) for run in time_residuals(found).runs]
        runs = [_with_added(run, added) for run, added in zip(found.runs, left, strict=True)]
        truths.append(fit(found.model, runs, found.x, iterations=0))
        lefts.append(left)
    effects = []
    for effect in library:
        if effect.flexible or effect.prior is not None:
            continue
        for shape in shapes_of(base, effect):
            with suppress(InputError):  # it cannot be added, or diverges with these values
                effects.append(_slopes(truths, effect, shape))
    return Null(truths[0], truths[1], lefts[0], lefts[1], effects)


def _with_added(run: SampledRun, added: np.ndarray) -> SampledRun:
    """The run with a signal (n, outputs) on top of its outputs, over the samples of its blocks."""
    measured, at = run.measured.copy(), 0
    for first, last, _ in run.reduction.spans:
        measured[first:last] += added[at : at + last - first]
        at += last - first
    return replace(run, measured=measured, data=run.reduction.reduce(measured)).with_initial_guesses(run.guess)


def _slopes(truths: Sequence[Fit], effect: type[Effect], shape: dict[str, float]) -> Slopes:
    """The derivatives at zero magnitude, for given nonlinear parameters. Raises InputError where they are not
    defined."""
    model: Any = truths[0].model.with_added_effects(effect, slopes_of_base=False)
    own, nonlinear = effect.free_parameters(), effect.nonlinear_parameters()
    rows = [model.component.table[model.experiment.parameter(effect, n)] for n in own]
    x = np.array(
        [shape.get(n, r.start if n in nonlinear else max(r.min, 0.0)) for n, r in zip(own, rows, strict=True)], float
    )
    at = np.array([r.start if n not in nonlinear and r.min > 0 else v for n, r, v in zip(own, rows, x, strict=True)])
    sizes = np.array([i for i, n in enumerate(own) if n not in nonlinear])
    low, high = (np.array([getattr(rows[i], end) for i in sizes]) - x[sizes] for end in ("min", "max"))
    both, shared = [], len(truths[0].model.names)
    for found in truths:
        matrix = np.zeros((len(found.residuals), len(sizes)))
        runs = [run.with_initial_guesses(run.guess) for run in found.runs]
        parts = [model.reduced(run, np.concatenate([found.of_run(i), at]))[1] for i, run in enumerate(runs)]
        matrix[: found.count] = np.concatenate(parts)[:, shared:][:, sizes]
        if not np.all(np.isfinite(matrix)):
            raise InputError(f"{effect.family}: derivatives that are not finite")
        both.append(matrix)
    return Slopes(effect, x, sizes, low, high, *both)


def permuted(left: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Residuals (n, outputs) in blocks as long as their correlation, permuted, each with a random sign."""
    n = len(left)
    length = max(*(correlation_length(y) for y in left.T), SHORTEST_BLOCK)
    turned = np.roll(left, int(rng.integers(n)), axis=0)
    blocks = np.array_split(turned, max(n // length, 1))
    return np.concatenate([rng.choice((-1.0, 1.0)) * blocks[i] for i in rng.permutation(len(blocks))])


def decided(null: Null, rng: np.random.Generator, criteria: Criteria) -> list[Outcome]:
    """The outcome of one draw of the null hypothesis, and that without the tolerance of what a base may miss."""
    drawn = [
        fit(found.model, [_with_added(run, permuted(e, rng)) for run, e in zip(found.runs, left, strict=True)], found.x,
            iterations=0)
        for found, left in ((null.fitted, null.left), (null.validation, null.left_validation))
    ]  # fmt: skip
    linear = _Linear(null, *drawn)
    gains = [linear.gain([i]) for i in range(len(null.effects))]
    best = {null.effects[i].effect: i for i in np.argsort(gains) if gains[i] > 0}  # the last one of each gains most
    singles = {i: linear.fit([i]) for i in best.values()}
    alone = linear.fit([])
    blocks = _Blocks(linear, min([alone, *singles.values()], key=lambda found: found.chi2), criteria)
    base, models = blocks.of([], alone), blocks.leading({(i,): found for i, found in singles.items()})
    pairs = dict.fromkeys(_joint_pairs(linear, list(best.values())))
    firsts = [m for m in one_per_families(models) if not blocks.is_undetermined(m.fit)][:LEADING_FAMILIES]
    for first in firsts:
        one = best[first.effects[0]]
        others = [i for i in best.values() if null.effects[i].effect.family not in first.families]
        second: dict[str, int] = {}  # of each family the effect that gains most, the family that gains most first
        for two in sorted(others, key=lambda two: -linear.gain([one, two])):
            second.setdefault(null.effects[two].effect.family, two)
        pairs |= dict.fromkeys((one, two) for two in list(second.values())[:SECOND_EFFECTS])
    fits: dict[tuple[int, ...], Fit] = {}
    for pair in {frozenset(pair): pair for pair in pairs}.values():
        with suppress(InputError):  # they cannot act together
            fits[pair] = linear.fit(pair)
    models += blocks.leading(fits)
    quiet = [run.with_densities(run.densities, "flexible_model") for run in drawn[1].runs]
    flexible = flexible_mean_square(replace(drawn[1], runs=quiet), blocks.scale)
    flexible = min([flexible, *(float(m.out_of_sample.mean()) for m in models)])
    motion = float(np.mean([np.mean((run.measured.std(axis=0) / blocks.scale) ** 2) for run in drawn[1].runs]))
    errors = {id(m): standard_errors(blocks.covariance(m.fit)) for m in models}
    counts = (len(blocks.blocks), len(blocks.validation_blocks))
    return [
        outcome(base, models, flexible, motion, counts, errors, replace(criteria, tolerance=tolerance))
        for tolerance in (criteria.tolerance, 0.0)
    ]


def _joint_pairs(linear: "_Linear", places: Sequence[int]) -> list[tuple[int, int]]:
    """The pairs with the largest joint gain, one of each pair of families."""
    families = {i: linear.null.effects[i].effect.family for i in places}
    both = [pair for pair in combinations(places, 2) if families[pair[0]] != families[pair[1]]]
    first: dict[frozenset[str], tuple[int, int]] = {}
    for pair in sorted(both, key=lambda pair: -linear.gain(pair)):
        first.setdefault(frozenset(families[i] for i in pair), pair)
    return list(first.values())[:JOINT_PAIRS]


class _Linear:
    """Base and effects fitted to one draw by linearisation at the truth; effects are given by their places in null.effects."""

    def __init__(self, null: Null, fitted: Fit, validation: Fit):
        self.null, self.drawn = null, (fitted, validation)
        self.free = fitted.residuals - null.basis @ (null.basis.T @ fitted.residuals)

    def _sizes(self, places: Sequence[int]) -> tuple[np.ndarray, float]:
        """The magnitudes (k,) of effects, and chi-square with them."""
        chi2 = float(self.free @ self.free)
        if not places:
            return np.zeros(0), chi2
        slopes = np.hstack([self.null.projected[i] for i in places])
        low, high = (np.concatenate([getattr(self.null.effects[i], end) for i in places]) for end in ("low", "high"))
        scale = np.linalg.norm(slopes, axis=0) + 1e-12
        q, r = np.linalg.qr(slopes / scale)
        pull = -q.T @ self.free
        solved = lsq_linear(r, pull, (np.minimum(low * scale, -1e-12), np.maximum(high * scale, 1e-12)))
        return solved.x / scale, chi2 - float(pull @ pull) + 2 * float(solved.cost)

    def gain(self, places: Sequence[int]) -> float:
        """By how much effects reduce chi-square of the base alone."""
        return float(self.free @ self.free) - self._sizes(places)[1]

    def fit(self, places: Sequence[int]) -> Fit:
        """The fit of base and effects. Raises InputError where the effects cannot act together."""
        found, effects = self.drawn[0], [self.null.effects[i] for i in places]
        sizes, chi2 = self._sizes(places)
        own = [s.x.copy() for s in effects]
        jacobians = [np.zeros((len(found.residuals), len(s.x))) for s in effects]
        left, parts = found.residuals, np.split(sizes, np.cumsum([len(s.sizes) for s in effects])[:-1])
        for values, jacobian, s, part in zip(own, jacobians, effects, parts, strict=False):
            values[s.sizes] += part
            jacobian[:, s.sizes] = s.fitted
            left = left + s.fitted @ part
        step = -np.linalg.pinv(found.jacobian) @ left
        shared = len(found.model.names)
        x, jacobian = found.x + step, found.jacobian
        return Fit(
            found.model.with_added_effects(*(s.effect for s in effects)), found.runs,
            np.concatenate([x[:shared], *own, x[shared:]]), chi2, left + jacobian @ step,
            np.hstack([jacobian[:, :shared], *jacobians, jacobian[:, shared:]]), found.count,
        )  # fmt: skip

    def on_validation_runs(self, places: Sequence[int], fitted: Fit) -> Fit:
        """The draw's validation runs with the values of a fit; only the deviations of these runs are estimated."""
        found, shared, at = self.drawn[1], len(self.drawn[1].model.names), len(self.drawn[0].model.names)
        left = found.residuals + found.jacobian[:, :shared] @ (fitted.x[:shared] - self.null.fitted.x[:shared])
        for s in (self.null.effects[i] for i in places):
            left = left + s.validation @ (fitted.x[at : at + len(s.x)] - s.x)[s.sizes]
            at += len(s.x)
        own = found.jacobian[:, shared:]
        return replace(found, residuals=left - own @ (np.linalg.pinv(own) @ left))


class _Blocks(CommonBlocks):
    """The blocks of one draw, and the models that are compared on them."""

    def __init__(self, linear: _Linear, leading: Fit, criteria: Criteria):
        super().__init__(leading, [], criteria)
        self.linear = linear
        length = max(last - first for _, first, last in self.blocks)
        self.validation_blocks = partition(time_residuals(linear.drawn[1], self.scale), length)

    def of(self, places: Sequence[int], found: Fit) -> ComparedModel:
        """The mean squares of the fit of these effects on all blocks."""
        validated = self.linear.on_validation_runs(places, found)
        return ComparedModel(
            found.model.effects,
            found,
            left_out_mean_squares(self.residuals(found), self.blocks),
            mean_squares(time_residuals(validated, self.scale), self.validation_blocks),
            self.floor,
        )

    def leading(self, fits: dict[tuple[int, ...], Fit]) -> list[ComparedModel]:
        """The models of the leading families, or pairs of families, that are not clearly behind."""
        made = [(np.log(m.fitted + m.floor), m) for m in (self.of(places, found) for places, found in fits.items())]
        made.sort(key=lambda pair: float(pair[0].mean()))
        near = [m for losses, m in made if not clearly_behind(losses, made[0][0])]
        kept = list(dict.fromkeys(m.families for m in near))[:LEADING_FAMILIES]
        return [m for m in near if m.families in kept]
