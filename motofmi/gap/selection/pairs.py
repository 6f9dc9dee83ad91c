"""Pairs of effects: every leading first effect with every second one, and the pairs that fit as well as the best.

The first effect of a pair need not be the best single effect, since a single effect is fitted so that it compensates in
part for the missing one. Therefore pairs are compared with pairs, and only a family that all near-best pairs contain is
certain.

A small error in the form of a large effect has residuals like those of another effect. Therefore the gain of a second
effect must exceed a share of the gain of the first. This is not required where the noise is known, no single effect is
adequate, and the second effect leads all others clearly.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from fmus.effects import Effect
from fmus.support.errors import InputError
from fmus.support.parallel import parallel_map
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import (
    Candidate,
    adequate,
    by_chance,
    has_determined_magnitudes,
    noise_is_known,
    one_each,
    reduced_by_noise,
)
from motofmi.gap.estimation.effect_fit import as_found, fit_each
from motofmi.gap.estimation.fit_result import Fit, PortableFit, penalty
from motofmi.gap.estimation.fitting import fit, fit_or_none
from motofmi.gap.estimation.screening import screen
from motofmi.gap.selection.candidate_search import NEAR_SHARE, search_candidates

FIRST_EFFECTS = 3  # leading families that are used as the first of a pair; each needs a search of the library


@dataclass(frozen=True)
class Pair:
    """Two effects fitted together: the second is a candidate on top of the first."""

    first: Candidate
    second: Candidate

    @property
    def members(self) -> tuple[Candidate, Candidate]:
        """Both effects."""
        return self.first, self.second

    @property
    def delta_bic(self) -> float:
        """The delta BIC of both effects over the base [1]."""
        return self.first.delta_bic + self.second.delta_bic

    @property
    def families(self) -> frozenset[str]:
        """The families of both effects."""
        return frozenset((self.first.family, self.second.family))


def pairs_of(
    best: Candidate,
    first: Sequence[Candidate],
    library: Sequence[type[Effect]],
    criteria: Criteria = Criteria(),
    on_progress: Callable[[Pair], None] = lambda pair: None,
    known: list[Fit] | None = None,
) -> list[Pair]:
    """The adequate pairs that are tied with the best one, which comes first.

    The list is empty where no second effect gains enough. `best` is the best single effect, `first` are all of them.
    Where `best` is adequate, a pair must contain it or have a larger delta BIC by the gain of a second effect.
    on_progress is called with the best pair after each first effect; `known` are fits that serve as starts, see
    `search_candidates`.
    """
    near = NEAR_SHARE * best.delta_bic
    others = [c for c in one_each(first) if c.family != best.family and c.effect in c.fit.model.effects]
    leading = [best, *(c for c in others if c.delta_bic > near)]
    one_suffices = adequate(best.fit, criteria)
    required = _second_gain(best, criteria)
    if one_suffices and _impossible(best.fit, required, criteria):
        return []
    least_of_pair = best.delta_bic + required if one_suffices else 0.0
    found: dict[frozenset[str], Pair] = {}
    for one in leading[:FIRST_EFFECTS]:
        usual = _second_gain(one, criteria)
        # Chi-square that a pair must reach to be adequate, to gain enough and to be near the best pair.
        needed = [reduced_by_noise(one.fit, criteria) * one.fit.freedom, *(p.second.fit.chi2 for p in found.values())]
        if one_suffices:
            needed.append(one.fit.chi2 - usual)
        least = criteria.second_effect_delta_bic if not one_suffices and noise_is_known(one.fit) else usual
        seconds = one_each(
            search_candidates(
                one.fit, library, leaders=4, least=least, others=False, beat=min(needed), known=known, criteria=criteria
            )
        )
        if not _leads(seconds, criteria):
            least = usual
        for two in seconds:
            pair = Pair(one, two)
            significant = (
                two.effect in two.fit.model.effects
                and two.delta_bic > least
                and has_determined_magnitudes(two.fit, criteria)
            )
            if significant and pair.delta_bic > least_of_pair and adequate(two.fit, criteria):
                found[pair.families] = max(found.get(pair.families, pair), pair, key=lambda p: p.delta_bic)
        if one_suffices and not found:
            return []
        if found:
            on_progress(max(found.values(), key=lambda pair: pair.delta_bic))
    ranked = sorted(found.values(), key=lambda pair: -pair.delta_bic)
    return [pair for pair in ranked if ranked[0].delta_bic - pair.delta_bic < criteria.tie_delta_bic]


def _second_gain(first: Candidate, criteria: Criteria) -> float:
    """The delta BIC [1] that a second effect must have beside a first one."""
    return max(criteria.second_effect_delta_bic, criteria.second_effect_share * first.delta_chi2)


def _impossible(found: Fit, gain: float, criteria: Criteria) -> bool:
    """Whether chi-square with the required gain would be smaller than that of noise, beyond chance."""
    return noise_is_known(found) and found.chi2 - gain < found.freedom - by_chance(found.freedom, criteria)


def _leads(candidates: Sequence[Candidate], criteria: Criteria) -> bool:
    """Whether the first family leads all others clearly."""
    first, *others = [c.delta_bic for c in candidates] or [0.0]
    return first > criteria.clear_lead_delta_bic + max(others, default=0.0)


def shared_families(pairs: Sequence[Pair]) -> frozenset[str]:
    """The families that all pairs contain."""
    return frozenset.intersection(*(pair.families for pair in pairs))


def in_simplest_forms(base: Fit, pair: Pair, library: Sequence[type[Effect]], criteria: Criteria) -> Pair:
    """The pair with the simplest forms that fit as well.

    The form of the first effect was selected before the second was added, and compensates for it in part.
    """
    for place in (0, 1):
        here = pair.members[place]
        forms = [e for e in library if e.family == here.family and not e.flexible and e is not here.effect]
        pairs = [pair, *_with_forms(base, pair, place, forms)]
        best = min(pairs, key=lambda p: p.second.fit.bic)
        near = [p for p in pairs if p.second.fit.bic - best.second.fit.bic < criteria.tie_delta_bic]
        pair = min(near, key=lambda p: (len(p.members[place].effect.free_parameters()), p.second.fit.bic))
    return pair


def single_effects_instead(
    base: Fit, pair: Pair, library: Sequence[type[Effect]], criteria: Criteria
) -> list[Candidate]:
    """Single effects that explain as much as a pair.

    They are the members of the pair, fitted alone from the pair's values, and the flexible forms of their families.
    """
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


def _with_forms(base: Fit, pair: Pair, place: int, forms: Sequence[type[Effect]]) -> list[Pair]:
    """The pairs with other forms of the effect at a place, 0 or 1, without those that cannot be fitted."""
    together, effects = pair.second.fit, [c.effect for c in pair.members]
    members = [[*effects[:place], form, *effects[place + 1 :]] for form in forms]
    portable_fits = parallel_map(
        lambda each: PortableFit.of(_fit_in_forms(base, together, each, each[place])), members, "fitting other forms"
    )
    return [
        _pair_of(base, pair, each, portable.on(base.model.with_added_effects(*each), together.runs))
        for each, portable in zip(members, portable_fits, strict=True)
        if portable is not None
    ]


def _fit_in_forms(base: Fit, together: Fit, effects: Sequence[type[Effect]], form: type[Effect]) -> Fit | None:
    """The fit of two effects, one of them in another form than in a fit together; None where that cannot be fitted."""
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
    return fit_or_none(model, together.runs, start)


def _pair_of(base: Fit, pair: Pair, effects: Sequence[type[Effect]], found: Fit) -> Pair:
    """The pair of effects that were fitted together, with the gains of another pair where its effect is the same."""
    penalties = [
        penalty(base.model.with_added_effects(e), base.runs) - base.penalty - found.spared(e) for e in effects
    ]
    gain = pair.second.fit.chi2 - found.chi2
    changed = [c.delta_chi2 + gain * (e is not c.effect) for e, c in zip(effects, pair.members, strict=True)]
    made = [Candidate(e, found, g, g - cost) for e, g, cost in zip(effects, changed, penalties, strict=True)]
    return Pair(*made)
