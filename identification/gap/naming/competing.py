"""The effects of a library against each other on top of a fit: screened, the leaders fitted, the best first."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.errors import InputError
from identification.gap.models.model import AnyModel
from identification.gap.naming.fitting import Fit, fit, lost, memories, remembering, with_all_felt
from identification.gap.naming.parallel import spread
from identification.gap.naming.screening import Signature, screen

SIGNIFICANT = 12.0  # dBIC of a first effect
TIE = 10.0  # dBIC within which effects cannot be told apart
CLEAR = 40.0  # dBIC by which a family without an adequate form must lead
ADEQUATE = 1.12  # reduced chi-square, at 1400 degrees of freedom and more
RIVAL = 0.15  # of an adequate effect's gain: what a rival must promise to be fitted
PLAIN = 0.3  # of that: an effect without shapes is fitted at once, and promises little where the base must move far for it
FAR = 30.0  # reduced chi-square of a base from which no effect is a small step
STRAINED = 10.0  # errors of what is known of a base, by which it is missed: the same
PROMISED = 0.5  # of a signature's gain (all of it where a base is far off): with less, a fit is tried from elsewhere
SMALLER = 0.2  # of the size of an effect, from where it is tried again
STARTS, MOST_STARTS = 2, 6  # signatures of a family that are fitted, and where nothing is adequate
NEAR = 0.5  # of the best one's dBIC: what a family must have for its other forms to be fitted, and to be the first of a pair
BEHIND = 300.0  # dBIC behind an adequate effect that another form of a family may make up for
FAR_LESS = 0.25  # of a gain: what a signature, which sees only small effects in full, must promise
HOPELESS = 10.0  # times the chi-square that is to be reached
LEADERS = 6  # families that are fitted first


@dataclass(frozen=True)
class Candidate:
    """An effect on top of the effects found so far: fitted, or with what the screening promises, and then `fit` lacks it."""

    effect: type[Effect]
    fit: Fit
    delta_chi2: float
    delta_bic: float

    @property
    def family(self) -> str:
        return self.effect.family

    @property
    def fitted(self) -> bool:
        return self.effect in self.fit.model.effects


@dataclass(frozen=True)
class _Answer:
    """What of a fit can travel between processes."""

    x: np.ndarray
    chi2: float
    residuals: np.ndarray
    jacobian: np.ndarray
    memories: list[Any]


def adequate(found: Fit) -> bool:
    """Whether noise alone explains what is left."""
    return found.reduced < reduced_by_noise(found)


def reduced_by_noise(found: Fit) -> float:
    """The largest reduced chi-square that noise alone gives."""
    return max(ADEQUATE, 1 + 4.5 * float(np.sqrt(2 / found.freedom)))


def compete(found: Fit, library: Sequence[type[Effect]], leaders: int = LEADERS, least: float = SIGNIFICANT, others: bool = True,
            beat: float = np.inf, known: list[Fit] | None = None) -> list[Candidate]:  # fmt: skip
    """The candidates on top of a fit, the best first and fitted ones before others.

    All are screened, the leading families are fitted (the others too, unless told not to) as far as they promise to be rivals, and
    those that come out best in all their forms. Nothing is fitted where the screening promises far less chi-square than `least`,
    and fits that creep far above the chi-square `beat` end where they are. Fits begin where others ended that are `known` (with
    another noise, or of other forms), the latest first; what is fitted here is added, the best last.
    """
    known = known if known is not None else []
    candidates = _compete(found, library, leaders, least, others, beat, known)
    known += [c.fit for c in reversed(candidates) if c.fitted]
    return candidates


def _compete(found: Fit, library: Sequence[type[Effect]], leaders: int, least: float, others: bool, beat: float, known: Sequence[Fit]) -> list[Candidate]:
    present = {e.family for e in found.model.effects}
    by_family: dict[str, list[type[Effect]]] = {}
    for effect in library:
        if effect.family not in present:
            by_family.setdefault(effect.family, []).append(effect)
    families = {name: sorted(forms, key=lambda e: (e.flexible, len(e.sought()))) for name, forms in by_family.items()}
    seen = screen(found, [form for forms in families.values() for form in _plain(forms)], keep=MOST_STARTS)
    of_family = {name: sorted((s for s in seen if s.effect.family == name), key=lambda s: -s.gain) for name in families}
    promised = {name: signatures[0].gain if signatures else 0.0 for name, signatures in of_family.items()}  # none where the effect cannot join
    order = sorted(families, key=lambda name: -promised[name])
    top = max((s.gain for s in seen), default=0.0)
    if top < max(SIGNIFICANT / 2, FAR_LESS * least):
        return ranked(_unfitted(found, s) for s in seen)
    candidates = fit_each(found, screen(found, _leading(found, library, known), keep=1), [], beat, known)
    led = {c.effect for c in candidates}
    waves = (order[:1], order[1:3], order[3:leaders], order[leaders:] if others else [])
    for wave in waves:  # what the first ones gain decides which others are worth a fit
        enough = max((min(c.delta_chi2, promised[c.family]) for c in candidates if c.fitted and adequate(c.fit)), default=0.0)
        of_each = ([s for s in of_family[name] if s.effect not in led][:STARTS] for name in wave)
        mine = [signatures for signatures in of_each if signatures]
        floor, rival = max(SIGNIFICANT / 2, (RIVAL if wave is waves[-1] else 0.02) * top), RIVAL * enough
        worth = [[s for s in signatures if s.gain >= max(floor, rival if s.effect.shapes() else PLAIN * rival)] for signatures in mine]
        candidates += fit_each(found, [s for signatures in worth for s in signatures], candidates, beat, known)
        candidates += [_unfitted(found, signatures[0]) for signatures, fitted in zip(mine, worth, strict=True) if not fitted]
    rest = set(order).difference(*waves)
    candidates = ranked([*candidates, *(_unfitted(found, s) for s in seen if s.effect.family in rest)])
    if candidates[0].fitted and candidates[0].fit.chi2 > HOPELESS * beat:  # no other form makes up for so much
        return candidates
    near = {c.family for c in candidates[:1] if c.delta_bic > SIGNIFICANT}
    near |= {c.family for c in candidates[:4] if candidates[0].delta_bic - c.delta_bic < CLEAR and c.delta_bic > SIGNIFICANT}
    best, reach = candidates[0], BEHIND if adequate(candidates[0].fit) else np.inf
    near |= {c.family for c in one_each(candidates)[:4] if c.delta_bic > max(SIGNIFICANT, NEAR * best.delta_bic, best.delta_bic - reach)}
    for flexible in (False, True):  # a curve of its own only where no plain form fits
        tried = {c.effect for c in candidates if c.fitted}
        more = [form for name in families if name in near for form in families[name] if form.flexible == flexible and form not in tried]
        candidates = ranked([*candidates, *fit_each(found, screen(found, more, keep=1), candidates, beat, known)])
        if not flexible and not adequate(candidates[0].fit):  # a small step says nothing of what a mode further off would bring
            tried_at_all = order if others else order[:leaders]
            more_starts = [s for name in tried_at_all for s in of_family[name][STARTS:] if s.gain > 0]
            if others and lost(found):  # nor what an effect brings that needs what the base has lost
                fitted = {c.family for c in candidates if c.fitted}
                more_starts += [s for name in order if name not in fitted for s in of_family[name][:1] if not s.effect.shapes()]
            candidates = ranked([*candidates, *fit_each(found, more_starts, [], beat, [])])
        if adequate(candidates[0].fit):
            return _finished(found, candidates)
    return candidates


def _leading(found: Fit, library: Sequence[type[Effect]], known: Sequence[Fit]) -> list[type[Effect]]:
    """The effect of the library that the latest of the known fits has beyond this one: what it reaches spares others a long way."""
    beyond = [set(other.model.effects) - set(found.model.effects) for other in known if set(other.model.effects) > set(found.model.effects)]
    return [effect for effects in beyond[-1:] if len(effects) == 1 for effect in effects if effect in library]


def _plain(forms: Sequence[type[Effect]]) -> list[type[Effect]]:
    """The forms of a family that stand for it: all that are not flexible, since a spring that drifts is not a damper that does.

    Those with a memory differ in the shape of their loop alone, and take long: the first one is enough.
    """
    plain = [form for form in forms if not form.flexible] or list(forms[:1])
    return [form for form in plain if form is plain[0] or not any(row.role == "state" for row in form.declared.values())]


def ranked(candidates: Iterable[Candidate]) -> list[Candidate]:
    """Fitted ones first, then by what they gain."""
    return sorted(candidates, key=lambda c: (not c.fitted, -c.delta_bic))


def fit_each(found: Fit, signatures: Sequence[Signature], so_far: Sequence[Candidate], beat: float, known: Sequence[Fit]) -> list[Candidate]:
    """The candidates of these signatures, as far as they have a chance beside those so far."""
    beat = min((beat, *(c.fit.chi2 for c in so_far if c.fitted and adequate(c.fit)))) + CLEAR
    known = [*known, *sorted((c.fit for c in so_far if c.fitted), key=lambda other: -other.chi2)]
    answers = spread(lambda signature: _packed(_best_fit(found, signature, beat, known)), signatures, "fitting effects")
    return [_unpacked(found, signature.effect, answer) or _unfitted(found, signature) for signature, answer in zip(signatures, answers, strict=True)]


def _finished(found: Fit, candidates: Sequence[Candidate]) -> list[Candidate]:
    """The candidates, ranked, with the adequate rivals of an adequate best fitted to their end: their fits may have ended since they crept."""
    best = candidates[0]
    crept = [c for c in one_each(candidates) if c.fitted and adequate(c.fit) and c.fit.chi2 > best.fit.chi2 + CLEAR] if adequate(best.fit) else []
    answers = spread(lambda c: _packed(_to_the_end(c.fit)), crept, "fitting rivals to their end")
    ended = [_unpacked(found, c.effect, answer) or c for c, answer in zip(crept, answers, strict=True)]
    return ranked([*ended, *(c for c in candidates if not any(c is other for other in crept))])


def _to_the_end(found: Fit) -> Fit | None:
    """A fit taken further; None where it was simulated on the way to it only."""
    try:
        return fit(found.model, found.runs, found.x)
    except InputError:
        return None


def _packed(found: Fit | None) -> _Answer | None:
    return None if found is None else _Answer(found.x, found.chi2, found.residuals, found.jacobian, memories(found.runs))


def _unpacked(found: Fit, effect: type[Effect], answer: _Answer | None) -> Candidate | None:
    """An effect on top of a fit, from what another process found; None where nothing near its start could be simulated, or it led nowhere."""
    if answer is None or answer.chi2 > found.chi2:
        return None
    model, runs = found.model.joined_by(effect), remembering(found.runs, answer.memories)
    return candidate(found, effect, Fit(model, runs, answer.x, answer.chi2, answer.residuals, answer.jacobian, found.count))


def _best_fit(found: Fit, signature: Signature, beat: float, known: Sequence[Fit]) -> Fit | None:
    """The best fit from several starts, the likeliest first; None where nothing can be simulated."""
    model = found.model.joined_by(signature.effect)
    far = found.reduced > FAR or bool(np.max(np.abs(found.residuals[found.count :]), initial=0.0) > STRAINED)
    blind = signature.gain < SIGNIFICANT and lost(found)  # no start is known to be better than another
    promised = np.inf if blind else signature.gain * (1.0 if far else PROMISED)
    best = None
    for start, kept, settled in _starts(found, model, signature, known, far or blind):
        try:
            fitted = fit(model, remembering(found.runs, kept), start, beat=beat if best is None else min(beat, best.chi2))
        except InputError:  # nothing near this start can be simulated
            continue
        best = fitted if best is None or fitted.chi2 < best.chi2 else best
        as_promised = found.chi2 - best.chi2 > promised and not (far and best.chi2 > beat)  # far off, all promises are small
        if adequate(best) or as_promised or (settled and fitted.chi2 > beat):
            break
    if best is None or best.chi2 > found.chi2:
        with suppress(InputError):
            best = fit(model, found.runs, _without_size(found, model, signature), beat=beat)
    return best


def _starts(found: Fit, model: AnyModel, signature: Signature, known: Sequence[Fit], far: bool) -> Iterator[tuple[np.ndarray, list[Any], bool]]:
    """What to begin from, with the runs' memories: what the effect had elsewhere (which is settled), its signature, another form, the values given."""
    shared, base, own = len(found.model.names), with_all_felt(found), signature.start  # the base may have done away with what the effect needs
    first = np.concatenate([base[:shared], own, base[shared:]])
    alike = [other for other in known if _families(other.model) == _families(model)]
    same = [other for other in alike if set(other.model.effects) == set(model.effects)]
    yield from ((as_found(model, other, first), memories(other.runs), True) for other in same[-1:])
    yield first, memories(found.runs), False
    yield np.concatenate([base[:shared], _smaller(model, signature), base[shared:]]), memories(found.runs), False
    if not same:
        yield from ((as_found(model, other, first), memories(other.runs), False) for other in alike[-1:])
    if far:  # a base that had to make up for so much may be no place to start from
        yield np.concatenate([model.start()[: len(model.base)], first[len(model.base) : shared], own]), memories(found.runs), False


def _families(model: AnyModel) -> list[str]:
    return sorted(effect.family for effect in model.effects)


def as_found(model: AnyModel, like: Fit, start: np.ndarray) -> np.ndarray:
    """A start with what another form or another noise gave to parameters of the same names."""
    values = dict(zip(like.model.names, like.x, strict=False))
    return np.concatenate([[values.get(n, x) for n, x in zip(model.names, start, strict=False)], like.x[len(like.model.names) :]])


def _smaller(model: AnyModel, signature: Signature) -> np.ndarray:
    """The signature's start with smaller sizes: far from where it is linear, a large one may lead nowhere."""
    start, first = signature.start.copy(), len(model.own) - len(signature.start)
    start[[i - first for i in model.sizes if i >= first]] *= SMALLER
    return start


def _without_size(found: Fit, model: AnyModel, signature: Signature) -> np.ndarray:
    """The fit with an effect as small as it may be: from where a further fit can only gain, however short its first step."""
    shared, own, before = len(found.model.names), signature.start.copy(), len(found.model.own)
    for i in model.sizes:
        if i >= before:
            own[i - before] = max(model.rows[i].min, 0.0)
    return np.concatenate([found.x[:shared], own, found.x[shared:]])


def _unfitted(found: Fit, signature: Signature) -> Candidate:
    """What the screening says, for an effect that is not worth a fit."""
    return Candidate(signature.effect, found, max(signature.gain, 0.0), signature.gain - len(signature.start) * np.log(found.count))


def candidate(found: Fit, effect: type[Effect], fitted: Fit) -> Candidate:
    """What an effect gains over a fit."""
    gain = found.chi2 - fitted.chi2
    return Candidate(effect, fitted, gain, gain - (fitted.price - found.price))


def best_of(candidates: Sequence[Candidate]) -> Candidate | None:
    """The best that was fitted; among plain forms of its family that are as good, the one with the fewest parameters."""
    fitted = [c for c in candidates if c.fitted]
    if not fitted:
        return None
    best = fitted[0]
    plain = [c for c in fitted if c.family == best.family and not c.effect.flexible and best.delta_bic - c.delta_bic < TIE]
    return min(plain, key=lambda c: len(c.effect.sought()), default=best)


def one_each(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best of every family, in order."""
    seen: dict[str, Candidate] = {}
    for c in candidates:
        seen.setdefault(c.family, c)
    return list(seen.values())
