"""Pairs of effects: every leading first effect with every second one, and the pairs that fit as well as the best.

The first effect of a pair need not be the best single effect, since a single effect compensates for the other as far as
it can. So pairs are compared as pairs, and only the families that all near-best pairs share are certain.

Small errors of a large effect look like another effect, so a second one must gain a share of the gain of the first. The
exception is where the noise is known, no single effect is adequate, and the second one leads all others clearly.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from fmus.effects import Effect
from fmus.support.errors import InputError
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import (
    Candidate,
    adequate,
    by_chance,
    noise_is_known,
    one_each,
    reduced_by_noise,
)
from motofmi.gap.estimation.effect_fit import as_found, fit_each
from motofmi.gap.estimation.fit_result import Fit, penalty
from motofmi.gap.estimation.fitting import fit
from motofmi.gap.estimation.screening import screen
from motofmi.gap.selection.candidate_search import NEAR, search_candidates

FIRSTS = 3  # leading families that are tried as the first of a pair; each costs a search of the library


@dataclass(frozen=True)
class Pair:
    """Two effects fitted together: the second is a candidate on top of the first."""

    first: Candidate
    second: Candidate

    @property
    def members(self) -> tuple[Candidate, Candidate]:
        return self.first, self.second

    @property
    def delta_bic(self) -> float:
        return self.first.delta_bic + self.second.delta_bic

    @property
    def families(self) -> frozenset[str]:
        return frozenset((self.first.family, self.second.family))


def pairs_of(best: Candidate, first: Sequence[Candidate], library: Sequence[type[Effect]], criteria: Criteria = Criteria(),
             so_far: Callable[[Pair], None] = lambda pair: None, known: list[Fit] | None = None) -> list[Pair]:  # fmt: skip
    """The adequate pairs that are tied with the best one, which comes first; none where no pair is
    worth its second effect.

    `best` is the best single effect. Where it is adequate, a pair must contain it or lead it. so_far is called with the
    best pair after each first effect; `known` are fits that serve as starts, see `search_candidates`.
    """
    leading = [
        best,
        *(
            c
            for c in one_each(first)
            if c.family != best.family and c.effect in c.fit.model.effects and c.delta_bic > NEAR * best.delta_bic
        ),
    ]
    one_will_do = adequate(best.fit, criteria)
    must_gain = _second_gain(best, criteria)
    if one_will_do and _impossible(best.fit, must_gain, criteria):
        return []
    worth = best.delta_bic + must_gain if one_will_do else 0.0
    found: dict[frozenset[str], Pair] = {}
    for one in leading[:FIRSTS]:
        # Pairs that are not adequate, gain too little or are far behind another one are not fitted to the end.
        usual = _second_gain(one, criteria)
        gained = [one.fit.chi2 - usual] if one_will_do else []
        enough = min(
            [
                reduced_by_noise(one.fit, criteria) * one.fit.freedom,
                *gained,
                *(pair.second.fit.chi2 for pair in found.values()),
            ]
        )
        least = criteria.second_effect_delta_bic if not one_will_do and noise_is_known(one.fit) else usual
        seconds = one_each(
            search_candidates(
                one.fit, library, leaders=4, least=least, others=False, beat=enough, known=known, criteria=criteria
            )
        )
        if not _leads(seconds, criteria):
            least = usual
        for two in seconds:
            pair = Pair(one, two)
            significant = two.effect in two.fit.model.effects and two.delta_bic > least
            if significant and pair.delta_bic > worth and adequate(two.fit, criteria):
                found[pair.families] = max(found.get(pair.families, pair), pair, key=lambda p: p.delta_bic)
        if one_will_do and not found:
            return []
        if found:
            so_far(max(found.values(), key=lambda pair: pair.delta_bic))
    ranked = sorted(found.values(), key=lambda pair: -pair.delta_bic)
    return [pair for pair in ranked if ranked[0].delta_bic - pair.delta_bic < criteria.tie_delta_bic]


def _second_gain(first: Candidate, criteria: Criteria) -> float:
    """What a second effect must gain on top of a first one."""
    return max(criteria.second_effect_delta_bic, criteria.second_effect_share * first.delta_chi2)


def _impossible(found: Fit, gain: float, criteria: Criteria) -> bool:
    """Whether the required gain would leave less than noise leaves by chance."""
    return noise_is_known(found) and found.chi2 - gain < found.freedom - by_chance(found.freedom, criteria)


def _leads(candidates: Sequence[Candidate], criteria: Criteria) -> bool:
    """Whether the first family leads all others clearly."""
    first, *others = [c.delta_bic for c in candidates] or [0.0]
    return first > criteria.clear_lead_delta_bic + max(others, default=0.0)


def shared_families(pairs: Sequence[Pair]) -> frozenset[str]:
    """The families that all pairs contain."""
    return frozenset.intersection(*(pair.families for pair in pairs))


def in_simplest_forms(base: Fit, pair: Pair, library: Sequence[type[Effect]], criteria: Criteria) -> Pair:
    """The pair with the simplest forms that fit as well: as a single effect, the first took a form that
    compensates for the second."""
    for place in (0, 1):
        here = pair.members[place]
        forms = [e for e in library if e.family == here.family and not e.flexible and e is not here.effect]
        every = [pair, *filter(None, (_with_form(base, pair, place, form) for form in forms))]
        best = min(every, key=lambda p: p.second.fit.bic)
        near = [p for p in every if p.second.fit.bic - best.second.fit.bic < criteria.tie_delta_bic]
        pair = min(near, key=lambda p: (len(p.members[place].effect.free_parameters()), p.second.fit.bic))
    return pair


def single_effects_instead(
    base: Fit, pair: Pair, library: Sequence[type[Effect]], criteria: Criteria
) -> list[Candidate]:
    """Single effects that explain as much as a pair: one of its members fitted from the pair's values, or a flexible
    form of its family."""
    together, found = pair.second.fit, []
    for member in pair.members:
        model = base.model.with_added_effects(member.effect)
        try:
            start, beat = as_found(model, together, model.start()), together.chi2 + criteria.second_effect_delta_bic
            made = Candidate.gained(base, member.effect, fit(model, together.runs, start, beat=beat))
        except InputError:
            continue
        found.append(made)
    curves = [e for e in library if e.family in pair.families and e.flexible]
    found += [c for c in fit_each(base, screen(base, curves, keep=1), [], together.chi2, [], criteria) if c.fitted]
    return [c for c in found if adequate(c.fit, criteria) and pair.delta_bic - c.delta_bic < _second_gain(c, criteria)]


def _with_form(base: Fit, pair: Pair, place: int, form: type[Effect]) -> Pair | None:
    """The pair with another form of one of its families; None where that cannot be fitted."""
    together = pair.second.fit
    effects = [c.effect for c in pair.members]
    effects[place] = form
    signatures = screen(base, [form], keep=1)
    if not signatures:
        return None
    model = base.model.with_added_effects(*effects)
    start = model.start()
    start[: len(model.base)] = together.x[: len(model.base)]
    for effect in effects:
        own = [model.experiment.parameter(effect, n) for n in effect.free_parameters()]
        values = signatures[0].start if effect is form else [together.x[together.model.names.index(n)] for n in own]
        start[[model.names.index(n) for n in own]] = values
    try:
        found = fit(model, together.runs, start)
    except InputError:
        return None
    penalties = [
        penalty(base.model.with_added_effects(e), base.runs) - base.penalty - found.spared(e) for e in effects
    ]
    gain = together.chi2 - found.chi2
    changed = [c.delta_chi2 + gain * (i == place) for i, c in enumerate(pair.members)]
    made = [Candidate(e, found, g, g - cost) for e, g, cost in zip(effects, changed, penalties, strict=True)]
    return Pair(*made)
