"""A verdict by chi-square that names dry friction, in the form and with the transition that fit best."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

from fmus.support.errors import InputError
from motofmi.gap.comparison.block_losses import partition
from motofmi.gap.comparison.residuals import time_residuals
from motofmi.gap.estimation.candidate import Candidate, ranked
from motofmi.gap.estimation.effect_fit import as_found
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import fit_or_none
from motofmi.gap.estimation.friction_transition import has_transition, worth_narrowing
from motofmi.gap.preprocessing.sampled_run import SampledRun
from motofmi.gap.selection.result import Verdict
from motofmi.gap.validation.before_after import before_and_after


def in_narrower_transition(verdict: Verdict, validation_runs: Sequence[SampledRun]) -> Verdict:
    """The verdict with its friction in the form and transition with the least criterion (see `friction_transition`), in
    the same noise; itself where no effect that is named has a transition of a given width."""
    best = verdict.best
    if verdict.verdict != "named" or not has_transition(best.model.effects):
        return verdict
    for narrow in worth_narrowing(best, _forms(verdict), len(partition(time_residuals(best)))):
        with suppress(InputError):  # it diverges on the validation runs
            return _with_best(verdict, narrow, validation_runs)
    return verdict


def _forms(verdict: Verdict) -> list[Fit]:
    """The best fit, and where it has one effect, fits of the other forms of dry friction with a given width."""
    best, effects = verdict.best, verdict.best.model.effects
    forms = [best]
    for other in verdict.candidates if len(effects) == 1 else []:
        if other.fitted and has_transition([other.effect]) and other.effect is not effects[0]:
            model = verdict.base.model.with_added_effects(other.effect)
            found = fit_or_none(model, best.runs, as_found(model, best, other.fit.x))
            forms += [found] if found else []
    return forms


def _with_best(verdict: Verdict, selected: Fit, validation_runs: Sequence[SampledRun]) -> Verdict:
    """The verdict with another best fit, of the same families. Raises InputError where that diverges on the validation
    runs."""
    base = verdict.base
    gap = before_and_after(base, selected, validation_runs, verdict.criteria)
    gained = {effect.family: Candidate.gained(base, effect, selected) for effect in selected.model.effects}
    candidates = ranked(gained[c.family] if c.effect in selected.model.effects else c for c in verdict.candidates)
    effects = [gained[c.family] for c in verdict.effects]
    return replace(verdict, best=selected, effects=effects, candidates=candidates, validation_gap=gap)
