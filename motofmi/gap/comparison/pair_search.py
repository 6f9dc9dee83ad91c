"""The pairs of effects that a comparison considers.

Some are the best of all pairs of a library, selected jointly (`estimation.joint_screening`): neither effect of a pair
needs to reduce the misfit alone. Others are a leading single effect with those of the largest gain beside it, since a
linear estimate from the base is inaccurate where one effect is large. The forms of the best pair are selected jointly
as well.
"""

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from fmus.effects import Effect
from fmus.support.deadline import time_is_up
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.comparison.compared_model import CommonBlocks, ComparedModel
from motofmi.gap.comparison.search import LEADING_FAMILIES, leading
from motofmi.gap.comparison.simplest_form import simplest_sufficient
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.effect_fit import as_found, best_portable_fit, candidate_of
from motofmi.gap.estimation.fit_result import Fit, PortableFit
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.joint_screening import PairSignature, screen_pairs
from motofmi.gap.estimation.screening import Signature, screen

JOINT_PAIRS = 3  # pairs of families with the largest joint gain, that are fitted
SECOND_EFFECTS = 3  # effects that are fitted as the second of a pair, for each first effect
OTHER_FORMS = 6  # pairs of other forms that are fitted, those with the fewest parameters
# Ratio of chi-square of the base to that of the best single effect above which no pair is fitted from the base: a
# linear estimate from a base that is so far from the data is no start, and the pairs beside single effects have one.
FAR_BASE = 1e4

Effects = frozenset[type[Effect]]


def pairs(
    blocks: CommonBlocks,
    base: Fit,
    firsts: Sequence[ComparedModel],
    library: Sequence[type[Effect]],
    criteria: Criteria,
) -> list[ComparedModel]:
    """The leading pairs evaluated on the blocks, and the best of them in other forms.

    Other forms are left out where a single effect is sufficient by the one-standard-error rule (`simplest_form`).
    firsts are the single effects, the leading one first. An effect whose magnitude is not determined alone leads no
    pair; it may be in one that is selected jointly. An effect at several elements may be the first of a pair.
    """
    firsts = [m for m in firsts if not blocks.is_undetermined(m.fit, [base])][:LEADING_FAMILIES]
    beat = min((m.fit.chi2 for m in firsts), default=base.chi2)
    plain = [effect for effect in library if not (effect.flexible or effect.at_one)]
    joint = screen_pairs(base, plain)
    of_families = {s.families: s for s in reversed(joint)}
    chosen = sorted(of_families.values(), key=lambda s: -s.gain)[: JOINT_PAIRS if base.chi2 < FAR_BASE * beat else 0]
    fits = _fitted(chosen, [base], base, beat, _beside(firsts, plain), criteria)
    _, near = leading(blocks, fits)
    models = blocks.refined_and_evaluated([fits[effects] for effects in near[:LEADING_FAMILIES]], "comparing pairs")
    if not models:
        return []
    best = min(models, key=lambda m: m.losses.mean())
    if len(simplest_sufficient([*firsts, best]).effects) < 2:
        return models
    others = [s for s in joint if s.families == best.families and frozenset(s.effects) not in fits]
    others.sort(key=lambda s: (sum(len(effect.free_parameters()) for effect in s.effects), -s.gain))
    in_other_forms = _fitted(others[:OTHER_FORMS], [best.fit, base], base, beat, [], criteria)
    return models + blocks.refined_and_evaluated(list(in_other_forms.values()), "comparing forms of a pair")


def _fitted(
    joint: Sequence[PairSignature],
    starts: Sequence[Fit],
    base: Fit,
    beat: float,
    beside: Sequence[tuple[Fit, Signature]],
    criteria: Criteria,
) -> dict[Effects, Fit]:
    """The fits of pairs: of joint signatures with less chi-square than the base, and of effects beside others with less
    than without them. All are fitted in one parallel step; of two fits of a pair the one with less chi-square is
    kept."""

    def fit_one(task: PairSignature | tuple[Fit, Signature]) -> PortableFit | None:
        if isinstance(task, PairSignature):
            return _fit_pair(task, starts, base, beat)
        first, second = task
        return best_portable_fit(first, second, first.chi2 + criteria.clear_lead_delta_bic, [], criteria)

    portable_fits = parallel_map(fit_one, [*joint, *beside], "fitting pairs")
    fits = {
        frozenset(signature.effects): portable.on(base.model.with_added_effects(*signature.effects), base.runs)
        for signature, portable in zip(joint, portable_fits, strict=False)
        if portable is not None and portable.chi2 < base.chi2
    }
    for task, portable in zip(beside, portable_fits[len(joint) :], strict=True):
        made = candidate_of(*task, portable)
        effects = frozenset(made.fit.model.effects)
        if made.fitted and (effects not in fits or made.fit.chi2 < fits[effects].chi2):
            fits[effects] = made.fit
    return fits


def _fit_pair(signature: PairSignature, starts: Sequence[Fit], base: Fit, beat: float) -> PortableFit | None:
    """The best fit of a pair from some fits, up to the first from which it is below `beat`.

    A start has the values of its fit, and those of the signature for what the fit does not contain.
    """
    found: list[Fit] = []
    for start in starts:
        if time_is_up() or (found and found[-1].chi2 < beat):
            break
        with suppress(InputError):  # it cannot be simulated from this start
            model = base.model.with_added_effects(*signature.effects)
            vector = np.concatenate([base.shared, *signature.starts, base.x[len(base.shared) :]])
            found.append(fit(model, start.runs, as_found(model, start, vector), beat=beat))
    return PortableFit.of(min(found, key=lambda f: f.chi2, default=None))


def _beside(firsts: Sequence[ComparedModel], plain: Sequence[type[Effect]]) -> list[tuple[Fit, Signature]]:
    """The fits of leading effects, each with the effects of the largest gain beside it; every pair of families once.

    Pairs that are selected jointly are among them: where one effect is large, their linear estimate from the base is a
    poor start.
    """
    tasks: list[tuple[Fit, Signature]] = []
    done: set[frozenset[str]] = set()
    for first in firsts:
        seconds = [s for s in _seconds(first, plain) if first.families | {s.effect.family} not in done]
        done = done | {first.families | {s.effect.family} for s in seconds}
        tasks += [(first.fit, second) for second in seconds]
    return tasks


def _seconds(first: ComparedModel, plain: Sequence[type[Effect]]) -> list[Signature]:
    """The effects with the largest screened gain beside a first one, each in its best form, the largest gain first."""
    others = [effect for effect in plain if effect.family not in first.families]
    order = sorted((s for s in screen(first.fit, others, keep=1) if s.gain > 0), key=lambda s: -s.gain)
    best_forms = {s.effect.family: s for s in reversed(order)}
    return sorted(best_forms.values(), key=lambda s: -s.gain)[:SECOND_EFFECTS]
