"""The comparison of base, single effects and pairs on runs whose noise is not known.

Source: Hansen, Lunde, Nason (2011) for the decision (see `confidence_set`); the other steps name theirs.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.comparison.closable import flexible_mean_square
from motofmi.gap.comparison.contender import Arena, Contender
from motofmi.gap.comparison.outcome import Outcome, outcome
from motofmi.gap.comparison.sandwich import sandwich_covariance
from motofmi.gap.comparison.search import leading_contenders, pairs
from motofmi.gap.comparison.simplest_form import one_per_families
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.validation.before_after import on_validation_runs


@dataclass(frozen=True)
class Comparison:
    """The outcome, the contenders that were compared (the least loss first), and the rms of the motion [1]."""

    outcome: Outcome
    base: Contender
    contenders: list[Contender]
    flexible: float  # mean square that a flexible regression leaves, in the units of the contenders
    motion: float  # mean square of the outputs, in the same units
    counts: tuple[int, int]  # blocks of fitted and of validation runs

    def __repr__(self) -> str:
        return f"Comparison({self.outcome.verdict}, {len(self.contenders)} contenders on {self.counts} blocks)"


def compare(base: Fit, singles: Sequence[Candidate], library: Sequence[type[Effect]], validation: Sequence[SampledRun],
            criteria: Criteria, so_far: Callable[[], None] = lambda: None) -> Comparison | None:  # fmt: skip
    """The comparison of a base and its fitted single effects, and of pairs of them; None where the base cannot be
    compared.

    validation are prepared runs with the noise of the fitted ones. so_far is called after each step.
    """
    leading = min((c.fit for c in singles), key=lambda found: found.chi2, default=base)
    arena = Arena(leading, validation, criteria)
    alone, contenders = leading_contenders(arena, base, singles)
    if alone is None:
        return None
    so_far()
    firsts = one_per_families(contenders)
    contenders += pairs(arena, firsts, library, criteria, so_far)
    so_far()
    covariances = {id(c): sandwich_covariance(arena.residuals(c.fit), arena.blocks) for c in contenders}
    errors = {key: np.sqrt(np.maximum(np.diag(v), 0.0)) for key, v in covariances.items()}
    flexible = _flexible(alone, contenders, arena)
    counts = (len(arena.blocks), len(arena.validation_blocks))
    motion = _motion(validation or base.runs, arena.scale)
    found = outcome(alone, contenders, flexible, motion, counts, errors, criteria)
    for contender in contenders:
        contender.fit.sandwich = covariances[id(contender)]
    return Comparison(found, alone, one_per_families(contenders), flexible, motion, counts)


def _flexible(base: Contender, contenders: Sequence[Contender], arena: Arena) -> float:
    """The least mean square that a flexible regression leaves of the base or of the best contender."""
    best = min((base, *contenders), key=lambda c: float(c.held_out.mean()))
    found = []
    for contender in (base, best):
        try:
            seen = (
                on_validation_runs(contender.fit, arena.validation, arena.criteria).fit
                if arena.validation
                else contender.fit
            )
            unknown_noise = replace(
                seen, runs=[run.with_densities(run.densities, "flexible_model") for run in seen.runs]
            )
            found.append(flexible_mean_square(unknown_noise, arena.scale))
        except InputError:
            continue
    return min([*found, float(best.held_out.mean())])


def _motion(runs: Sequence[SampledRun], scale: np.ndarray) -> float:
    """The mean square of the runs' outputs about their means, in units of the scale (outputs,)."""
    return float(np.mean([np.mean((run.measured.std(axis=0) / scale) ** 2) for run in runs]))
