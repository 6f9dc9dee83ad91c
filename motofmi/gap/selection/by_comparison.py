"""The verdict of a comparison on blocks, for data that no model of the library explains within their noise.

The residuals of the best model take the place of the noise: chi-square and delta BIC are in units of their power. A
delta BIC then only orders the candidates; the verdict is that of the comparison.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.comparison.compare import Comparison
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, ranked
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.selection.result import Verdict
from motofmi.gap.validation.before_after import before_and_after


def in_units_of_residuals(
    best: Fit, base: Fit, singles: Sequence[Candidate], validation_runs: Sequence[SampledRun]
) -> tuple[Fit, list[Candidate], list[SampledRun]]:
    """Base, single effects and validation runs with the noise scaled to the residuals of the best fit.

    The noise before is that of the base. Where an effect leaves a thousandth of it, the chi-square of two effects
    differs by less than the least change for which a fit is continued, or initial states are improved.
    """
    factor = best.chi2 / best.count
    base = base.with_scaled_noise(factor)
    singles = [Candidate.gained(base, c.effect, c.fit.with_scaled_noise(factor)) for c in singles]
    return base, singles, [run.with_scaled_noise(factor) for run in validation_runs]


def verdict_by_comparison(
    compared: Comparison, singles: Sequence[Candidate], validation: Sequence[SampledRun], criteria: Criteria
) -> Verdict:
    """The verdict of a comparison; of two named effects the one with the lesser loss alone comes first.

    singles are the fitted single effects, validation are the prepared validation runs.
    """
    result, base = compared.outcome, compared.base.fit
    nearest = result.best if result.best is not compared.base else result.nearest or compared.base
    scale = nearest.fit.count / nearest.fit.chi2
    fitted = {c.effects[0]: c.fit for c in compared.models if len(c.effects) == 1}
    candidates = ranked(_candidate(base, c.effect, fitted.get(c.effect, c.fit), scale) for c in singles)
    candidates.sort(key=lambda c: c.effect not in nearest.effects)
    alone = {m.effects[0].family: m.losses.mean() for m in compared.models if len(m.effects) == 1}
    effects = sorted(result.best.effects, key=lambda effect: alone.get(effect.family, compared.base.losses.mean()))
    named = [_candidate(base, effect, result.best.fit, scale) for effect in effects]
    families = frozenset.intersection(*(c.families for c in result.members)) if result.members else frozenset()
    others = {e.family: (e, c) for c in reversed(result.members) for e in c.effects if e.family not in families}
    tied = [_candidate(base, effect, model.fit, scale) for effect, model in reversed(others.values())]
    verdict = Verdict(
        result.verdict,
        base,
        nearest.fit if result.verdict != "none" else base,
        [c for c in named if c.family in families] if result.verdict == "named" else [],
        tied if result.verdict in ("named", "tied") else [],
        candidates,
        outside_library=_candidate(base, compared.law.effects[0], compared.law.fit, scale) if compared.law else None,
        criteria=criteria,
        comparison=compared,
    )
    with suppress(InputError):
        verdict.base, verdict.best = with_remaining_noise(verdict.base, verdict.best)
        known = compared.base.validated, (nearest if result.verdict != "none" else compared.base).validated
        verdict.validation_gap = before_and_after(verdict.base, verdict.best, validation, criteria, known)
    return verdict


def _candidate(base: Fit, effect: type[Effect], fitted: Fit, scale: float) -> Candidate:
    """The candidate of a fitted effect; scale is the factor from chi-square to units of the best model's residuals."""
    gain = (base.chi2 - fitted.chi2) * scale
    return Candidate(effect, fitted, gain, gain - (fitted.penalty - base.penalty))


def with_remaining_noise(base: Fit, best: Fit) -> tuple[Fit, Fit]:
    """Both fits, with the same parameters, on runs with the noise that a flexible model estimates from the best one."""
    with_noise = best.runs_with_remaining_noise()
    evaluated = []
    for found in (base, best):
        runs = [new.with_initial_guesses(old.guess) for new, old in zip(with_noise, found.runs, strict=True)]
        again = fit(found.model, runs, found.x, iterations=0)
        evaluated.append(replace(again, sandwich=found.sandwich))
    return evaluated[0], evaluated[0] if best is base else evaluated[1]
