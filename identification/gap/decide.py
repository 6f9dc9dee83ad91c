"""Which effect is missing: none, named, tied or unknown.

    dchi2 = chi2(base) - chi2(base + effect)        dBIC = dchi2 - k ln n

Every candidate is fitted with the base refitted. An effect must gain dBIC 12; those within dBIC 10 of the best, and
as adequate, are tied. Adequate is a reduced chi-square that noise alone gives. Where no form of a family is adequate,
but the family closes over half of the excess and beats every other by dBIC 40, it is named with its form open.
A second effect must gain dBIC 15 and half a per cent of what the first gained.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fmus.effects import Effect
from fmus.errors import InputError
from fmus.progress import track
from identification.gap.fitting import Fit, fit
from identification.gap.model import Model
from identification.gap.runs import Run
from identification.gap.screening import Signature, screen
from identification.gap.test_stand import TestStand

SIGNIFICANT = 12.0  # dBIC of a first effect
SECOND = 15.0  # dBIC of a second one
SHARE = 0.005  # of the first one's gain: below it, small errors of the model of a large effect look like another
TIE = 10.0  # dBIC within which effects cannot be told apart
CLEAR = 40.0  # dBIC by which a family without an adequate form must lead
ADEQUATE = 1.12  # reduced chi-square, at 1400 degrees of freedom and more
RIVAL = 0.4  # of an adequate effect's gain: what a rival must promise to be fitted
LEADERS = 6  # families that are fitted


@dataclass(frozen=True)
class Candidate:
    """An effect on top of the effects found so far, fitted."""

    effect: type[Effect]
    fit: Fit
    delta_chi2: float
    delta_bic: float

    @property
    def family(self) -> str:
        return self.effect.family


@dataclass
class Verdict:
    """What was found. `best` is the fit that it rests on; candidates are those of every round, the best first."""

    verdict: str
    base: Fit
    best: Fit
    effects: list[Candidate] = field(default_factory=list)
    tied: list[Candidate] = field(default_factory=list)
    candidates: list[Candidate] = field(default_factory=list)
    open_form: bool = False


def adequate(found: Fit) -> bool:
    """Whether noise alone explains what is left."""
    return found.reduced < max(ADEQUATE, 1 + 4.5 * np.sqrt(2 / found.freedom))


def decide(stand: TestStand, runs: Sequence[Run], library: Sequence[type[Effect]]) -> Verdict:
    """The verdict on runs, with the effects of a library. Raises InputError where the base cannot be fitted.

    Its fits rest on the noise that the best of them leaves.
    """
    verdict = _decide(stand, runs, library)
    best = verdict.best
    quiet = [run.with_noise_beside(best.model.output(run, best.of_run(i), slopes=False)[0]) for i, run in enumerate(runs)]
    if best is verdict.base:
        verdict.base = verdict.best = fit(best.model, quiet, best.x)
    else:
        verdict.base, verdict.best = (fit(f.model, quiet, f.x) for f in (verdict.base, best))
    return verdict


def _decide(stand: TestStand, runs: Sequence[Run], library: Sequence[type[Effect]]) -> Verdict:
    model = Model(stand)
    base = fit(model, runs, model.start())
    first = compete(base, library)
    best = _best(first)
    if best is None or best.delta_bic < SIGNIFICANT:
        return Verdict("none" if adequate(base) else "unknown", base, base, candidates=first)
    second = _second(best, library)
    found = Verdict("named", base, best.fit, [best], candidates=first)
    if second is not None:
        members = [c for c in second[1] if second[0].delta_bic - c.delta_bic < TIE and c.family != second[0].family]
        if adequate(second[0].fit):
            pair = _plainest(base, best, second[0], library)
            return Verdict("named", base, pair[1].fit, list(pair), members, first)
    if adequate(best.fit):
        found.tied = [c for c in _one_each(first) if best.delta_bic - c.delta_bic < TIE and adequate(c.fit)]
        if len(found.tied) > 1:
            found.verdict, found.effects = "tied", []
        else:
            found.tied = []
            found.open_form = best.effect.flexible
        return found
    others = [c for c in _one_each(first) if c.family != best.family]
    excess, left = base.reduced - 1, best.fit.reduced - 1
    if left < 0.5 * excess and all(best.delta_bic - c.delta_bic > CLEAR for c in others):
        found.open_form = True
        return found
    return Verdict("unknown", base, best.fit, candidates=first)


def compete(found: Fit, library: Sequence[type[Effect]], leaders: int = LEADERS) -> list[Candidate]:
    """The candidates on top of a fit, the best first: all screened by one form, the leading families fitted in all forms."""
    present = {e.family for e in found.model.effects}
    by_family: dict[str, list[type[Effect]]] = {}
    for effect in library:
        if effect.family not in present:
            by_family.setdefault(effect.family, []).append(effect)
    families = {name: sorted(forms, key=lambda e: (e.flexible, len(e.parameters()))) for name, forms in by_family.items()}
    seen = [s for name, forms in track(list(families.items()), "screening effects") for s in screen(found, forms[:1])]
    order = sorted(families, key=lambda name: -max((s.gain for s in seen if s.effect.family == name), default=0.0))
    top = max((s.gain for s in seen), default=0.0)
    if top < SIGNIFICANT / 2:
        return [_unfitted(found, s) for s in seen]
    candidates: list[Candidate] = []
    for name in track(order[:leaders], "fitting effects"):
        mine = [s for s in seen if s.effect.family == name]
        enough = max((c.delta_chi2 for c in candidates if adequate(c.fit)), default=0.0)
        if max(s.gain for s in mine) < max(SIGNIFICANT / 2, 0.02 * top, RIVAL * enough):
            candidates += [_unfitted(found, s) for s in mine[:1]]
            continue
        candidates += [c for s in mine if (c := _fitted(found, s)) is not None]
    candidates += [_unfitted(found, s) for s in seen if s.effect.family in order[leaders:]]
    candidates.sort(key=lambda c: -c.delta_bic)
    near = {c.family for c in candidates[:1] if c.delta_bic > SIGNIFICANT}
    near |= {c.family for c in candidates[:4] if candidates[0].delta_bic - c.delta_bic < CLEAR and c.delta_bic > SIGNIFICANT}
    if not adequate(candidates[0].fit):
        near |= {c.family for c in _one_each(candidates)[:3] if c.delta_bic > 0.5 * candidates[0].delta_bic}
    for flexible in (False, True):  # a curve of its own only where no plain form fits
        more = [form for name in near for form in families[name][1:] if form.flexible == flexible]
        candidates += [c for s in screen(found, track(more, "fitting other forms"), keep=1) if (c := _fitted(found, s)) is not None]
        candidates.sort(key=lambda c: -c.delta_bic)
        if adequate(candidates[0].fit):
            break
    return candidates


def _fitted(found: Fit, signature: Signature) -> Candidate | None:
    model = Model(found.model.stand, [*found.model.effects, signature.effect])
    shared = len(found.model.names)
    start = np.concatenate([found.x[:shared], signature.start, found.x[shared:]])
    try:
        return _candidate(found, signature.effect, fit(model, found.runs, start))
    except InputError:  # nothing near this start can be simulated
        return None


def _unfitted(found: Fit, signature: Signature) -> Candidate:
    """What the screening says, for an effect that is not worth a fit."""
    return Candidate(signature.effect, found, max(signature.gain, 0.0), signature.gain - len(signature.start) * np.log(found.count))


def _candidate(found: Fit, effect: type[Effect], fitted: Fit) -> Candidate:
    gain = found.chi2 - fitted.chi2
    more = len(fitted.model.names) - len(found.model.names)
    return Candidate(effect, fitted, gain, gain - more * float(np.log(found.count)))


def _best(candidates: Sequence[Candidate]) -> Candidate | None:
    """The best; among forms of its family that are as good, the simplest that is adequate."""
    if not candidates:
        return None
    best = candidates[0]
    plain = [c for c in candidates if c.family == best.family and not c.effect.flexible and best.delta_bic - c.delta_bic < TIE]
    return plain[0] if plain else best


def _one_each(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The best of every family, in order."""
    seen: dict[str, Candidate] = {}
    for c in candidates:
        seen.setdefault(c.family, c)
    return list(seen.values())


def _plainest(base: Fit, first: Candidate, second: Candidate, library: Sequence[type[Effect]]) -> tuple[Candidate, Candidate]:
    """The two effects in the forms that fit best together: alone, the first one's form makes up for the second."""
    best, pair = second.fit, (first.effect, second.effect)
    for place in (0, 1):
        for form in [e for e in library if e.family == pair[place].family and e is not pair[place] and not e.flexible]:
            tried = (form, pair[1]) if place == 0 else (pair[0], form)
            model = Model(base.model.stand, tried)
            shared = best.x[: len(base.model.names)]
            signature = screen(base, [form], keep=1)
            if not signature:
                continue
            kept = [best.x[best.model.names.index(model.stand.parameter(e, n))] if e in pair else s
                    for e in tried for n, s in zip([n for n in e.parameters() if n not in e.given], _start(signature[0], e), strict=True)]  # fmt: skip
            try:
                found = fit(model, base.runs, np.concatenate([shared, kept]))
            except InputError:
                continue
            if _bic(found) < _bic(best) + TIE * (len(model.names) < len(best.model.names)):
                best, pair = found, tried
    gains = [(base.chi2 - first.fit.chi2), first.fit.chi2 - best.chi2]
    return tuple(Candidate(e, best, g, g - np.log(base.count) * sum(n not in e.given for n in e.parameters()))  # type: ignore[return-value]
                 for e, g in zip(pair, gains, strict=True))


def _start(signature: Signature, effect: type[Effect]) -> np.ndarray:
    """Where an effect's parameters start: the signature's, or wherever they are (the caller reads those)."""
    return signature.start if effect is signature.effect else np.zeros(sum(n not in effect.given for n in effect.parameters()))


def _bic(found: Fit) -> float:
    return found.chi2 + len(found.model.names) * float(np.log(found.count))


def _second(best: Candidate, library: Sequence[type[Effect]]) -> tuple[Candidate, list[Candidate]] | None:
    """A second effect on top of the first, with its rivals, if there is one."""
    rivals = compete(best.fit, library, leaders=4)
    found = _best(rivals)
    threshold = max(SECOND, SHARE * best.delta_chi2)
    if found is None or found.delta_bic < threshold:
        return None
    return found, _one_each(rivals)

