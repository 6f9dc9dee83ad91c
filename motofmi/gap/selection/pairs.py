"""Two effects together: every leading first effect with every second one on top of it, and the pairs that fit as well as the best.

The first effect of a pair need not be the one that fits best alone: alone, an effect makes up for the other as far as
it can. So the pairs compete, and only the families that all of the near-best pairs share are sure.

Small errors of a large effect look like another, so a second one must gain a share of what the first one does: unless the
noise is known, no effect is adequate alone, and this one, on top of the first, is clear of all others.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from fmus.effects import Effect
from fmus.errors import InputError
from identification.gap.naming.candidate import (
    CLEAR,
    TIE,
    Candidate,
    adequate,
    by_chance,
    knows_its_noise,
    one_each,
    reduced_by_noise,
)
from identification.gap.naming.competing import NEAR, compete
from identification.gap.naming.fitted import Fit, price
from identification.gap.naming.fitting import fit
from identification.gap.naming.joining import as_found, fit_each
from identification.gap.naming.screening import screen

SECOND = (15.0, 0.005)  # dBIC of a second effect, and its share of the first one's gain
FIRSTS = 3  # leading families that may be the first of a pair


@dataclass(frozen=True)
class Pair:
    """Two effects fitted together: the second's candidate rests on the first's."""

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


def pairs_of(best: Candidate, first: Sequence[Candidate], library: Sequence[type[Effect]], second: tuple[float, float] = SECOND,
             so_far: Callable[[Pair], None] = lambda pair: None, known: list[Fit] | None = None) -> list[Pair]:  # fmt: skip
    """The adequate pairs within TIE of the best one, which comes first; none where no pair is worth its second effect.

    `best` is the best of the single effects. Where it is adequate, a pair must contain it or beat it. `second` says what the
    second effect must gain. so_far is told the best pair after each effect whose seconds were tried; `known` are fits to begin from, see `compete`.
    """
    leading = [best, *(c for c in one_each(first) if c.family != best.family and c.effect in c.fit.model.effects and c.delta_bic > NEAR * best.delta_bic)]
    one_will_do = adequate(best.fit)
    must_gain = max(second[0], second[1] * best.delta_chi2)
    if one_will_do and _impossible(best.fit, must_gain):
        return []
    worth = best.delta_bic + must_gain if one_will_do else 0.0
    found: dict[frozenset[str], Pair] = {}
    for one in leading[:FIRSTS]:
        # A pair that is not adequate is none, nor one that gains too little or is far behind another.
        usual = max(second[0], second[1] * one.delta_chi2)
        gained = [one.fit.chi2 - usual] if one_will_do else []
        enough = min([reduced_by_noise(one.fit) * one.fit.freedom, *gained, *(pair.second.fit.chi2 for pair in found.values())])
        least = second[0] if not one_will_do and knows_its_noise(one.fit) else usual
        seconds = one_each(compete(one.fit, library, leaders=4, least=least, others=False, beat=enough, known=known))
        if not _leads(seconds):
            least = usual
        for two in seconds:
            pair = Pair(one, two)
            significant = two.effect in two.fit.model.effects and two.delta_bic > least
            if significant and pair.delta_bic > worth and adequate(two.fit):
                found[pair.families] = max(found.get(pair.families, pair), pair, key=lambda p: p.delta_bic)
        if one_will_do and not found:
            return []
        if found:
            so_far(max(found.values(), key=lambda pair: pair.delta_bic))
    ranked = sorted(found.values(), key=lambda pair: -pair.delta_bic)
    return [pair for pair in ranked if ranked[0].delta_bic - pair.delta_bic < TIE]


def _impossible(found: Fit, gain: float) -> bool:
    """Whether what is to be gained would leave less than noise ever leaves."""
    return knows_its_noise(found) and found.chi2 - gain < found.freedom - by_chance(found.freedom)


def _leads(candidates: Sequence[Candidate]) -> bool:
    """Whether the first of the families is clear of all others."""
    first, *others = [c.delta_bic for c in candidates] or [0.0]
    return first > CLEAR + max(others, default=0.0)


def sure(pairs: Sequence[Pair]) -> frozenset[str]:
    """The families that all pairs have."""
    return frozenset.intersection(*(pair.families for pair in pairs))


def plainest(base: Fit, pair: Pair, library: Sequence[type[Effect]]) -> Pair:
    """The two effects in the plainest forms that fit well together: alone, the first one's form makes up for the second."""
    for place in (0, 1):
        here = pair.members[place]
        forms = [e for e in library if e.family == here.family and not e.flexible and e is not here.effect]
        every = [pair, *filter(None, (_with_form(base, pair, place, form) for form in forms))]
        best = min(every, key=lambda p: p.second.fit.bic)
        near = [p for p in every if p.second.fit.bic - best.second.fit.bic < TIE]
        pair = min(near, key=lambda p: (len(p.members[place].effect.sought()), p.second.fit.bic))
    return pair


def alone(base: Fit, pair: Pair, library: Sequence[type[Effect]], second: tuple[float, float] = SECOND) -> list[Candidate]:
    """What does alone what a pair does: one of its members, once it begins where the pair ended, or its family with a curve of its own."""
    together, found = pair.second.fit, []
    for member in pair.members:
        model = base.model.joined_by(member.effect)
        try:
            made = Candidate.gained(base, member.effect, fit(model, together.runs, as_found(model, together, model.start()), beat=together.chi2 + second[0]))
        except InputError:
            continue
        found.append(made)
    curves = [e for e in library if e.family in pair.families and e.flexible]
    found += [c for c in fit_each(base, screen(base, curves, keep=1), [], together.chi2, []) if c.fitted]
    return [c for c in found if adequate(c.fit) and pair.delta_bic - c.delta_bic < max(second[0], second[1] * c.delta_chi2)]


def _with_form(base: Fit, pair: Pair, place: int, form: type[Effect]) -> Pair | None:
    """The pair with another form of one of its families, None where that cannot be fitted."""
    together = pair.second.fit
    effects = [c.effect for c in pair.members]
    effects[place] = form
    signatures = screen(base, [form], keep=1)
    if not signatures:
        return None
    model = base.model.joined_by(*effects)
    start = model.start()
    start[: len(model.base)] = together.x[: len(model.base)]
    for effect in effects:
        own = [model.stand.parameter(effect, n) for n in effect.sought()]
        values = signatures[0].start if effect is form else [together.x[together.model.names.index(n)] for n in own]
        start[[model.names.index(n) for n in own]] = values
    try:
        found = fit(model, together.runs, start)
    except InputError:
        return None
    prices = [price(base.model.joined_by(e), base.runs) - base.price for e in effects]
    gain = together.chi2 - found.chi2
    changed = [c.delta_chi2 + gain * (i == place) for i, c in enumerate(pair.members)]
    made = [Candidate(e, found, g, g - cost) for e, g, cost in zip(effects, changed, prices, strict=True)]
    return Pair(*made)
