"""An effect joins a fit: everything is fitted again with it, from several starts, many effects side by side."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from fmus.effects import Effect
from fmus.errors import InputError
from fmus.parallel import spread
from identification.gap.models.model import AnyModel
from identification.gap.naming.candidate import CLEAR, SIGNIFICANT, Candidate, adequate, one_each, ranked
from identification.gap.naming.fitted import Answer, Fit, memories, remembering
from identification.gap.naming.fitting import attempt, fit, lost, with_all_felt
from identification.gap.naming.screening import Signature

FAR = 30.0  # reduced chi-square of a base from which no effect is a small step
STRAINED = 10.0  # errors of what is known of a base, by which it is missed: the same
PROMISED = 0.5  # of a signature's gain (all of it where a base is far off): with less, a fit is tried from elsewhere
SMALLER = 0.2  # of the size of an effect, from where it is tried again
OUT_OF_REACH = 4.0  # times the chi-square that is to be reached: no other start makes up for so much where a fair one has led to something


def fit_each(found: Fit, signatures: Sequence[Signature], so_far: Sequence[Candidate], beat: float, known: Sequence[Fit]) -> list[Candidate]:
    """The candidates of these signatures, as far as they have a chance beside those so far."""
    beat = min((beat, *(c.fit.chi2 for c in so_far if c.fitted and adequate(c.fit)))) + CLEAR
    known = [*known, *sorted((c.fit for c in so_far if c.fitted), key=lambda other: -other.chi2)]
    answers = spread(lambda signature: Answer.of(_best_fit(found, signature, beat, known)), signatures, "fitting effects")
    return [_unpacked(found, signature.effect, answer) or Candidate.promised(found, signature) for signature, answer in zip(signatures, answers, strict=True)]


def finished(found: Fit, candidates: Sequence[Candidate]) -> list[Candidate]:
    """The ranked candidates again, with the adequate rivals of an adequate best fitted to their end: their fits may have ended since they crept."""
    best = candidates[0]
    crept = [c for c in one_each(candidates) if c.fitted and adequate(c.fit) and c.fit.chi2 > best.fit.chi2 + CLEAR] if adequate(best.fit) else []
    answers = spread(lambda c: Answer.of(attempt(c.fit.model, c.fit.runs, c.fit.x)), crept, "fitting rivals to their end")
    ended = [_unpacked(found, c.effect, answer) or c for c, answer in zip(crept, answers, strict=True)]
    return ranked([*ended, *(c for c in candidates if not any(c is other for other in crept))])


def _unpacked(found: Fit, effect: type[Effect], answer: Answer | None) -> Candidate | None:
    """An effect on top of a fit, from what another process found; None where nothing near its start could be simulated, or it led nowhere."""
    if answer is None or answer.chi2 > found.chi2:
        return None
    return Candidate.gained(found, effect, answer.on(found.model.joined_by(effect), found.runs))


def _best_fit(found: Fit, signature: Signature, beat: float, known: Sequence[Fit]) -> Fit | None:
    """The best fit from several starts, the likeliest first; None where nothing can be simulated."""
    model = found.model.joined_by(signature.effect)
    far = found.reduced > FAR or bool(np.max(np.abs(found.residuals[found.count :]), initial=0.0) > STRAINED)
    astray = lost(found)
    blind = astray and signature.gain < SIGNIFICANT  # no start is known to be better than another
    promised = np.inf if blind else signature.gain * (1.0 if far else PROMISED)
    least = contained(model, known)
    best = None
    for start, kept, settled in _starts(found, model, signature, known, far or blind):
        try:
            fitted = fit(model, remembering(found.runs, kept), start, beat=beat if best is None else min(beat, best.chi2))
        except InputError:  # nothing near this start can be simulated
            continue
        best = fitted if best is None or fitted.chi2 < best.chi2 else best
        as_promised = found.chi2 - best.chi2 > promised and not (far and best.chi2 > beat)  # far off, all promises are small
        as_promised &= best.chi2 < least
        out_of_reach = not astray and OUT_OF_REACH * beat < fitted.chi2 < found.chi2
        if adequate(best) or as_promised or out_of_reach or (settled and fitted.chi2 > beat):
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
    same = [other for other in alike if set(other.model.effects) == set(model.effects) and other.chi2 < contained(model, known)]
    yield from ((as_found(model, other, first), memories(other.runs), True) for other in same[-1:])
    yield first, memories(found.runs), False
    yield np.concatenate([base[:shared], _smaller(model, signature), base[shared:]]), memories(found.runs), False
    if not same:
        yield from ((as_found(model, other, first), memories(other.runs), False) for other in alike[-1:])
    if far:  # a base that had to make up for so much may be no place to start from
        yield np.concatenate([model.start()[: len(model.base)], first[len(model.base) : shared], own]), memories(found.runs), False


def contained(model: AnyModel, known: Sequence[Fit]) -> float:
    """The least chi-square of forms that a model's form contains, which its own can only undercut."""
    return min((other.chi2 for other in known if _families(other.model) == _families(model) and set(other.model.own) < set(model.own)), default=np.inf)


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
