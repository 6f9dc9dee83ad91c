"""The effects of a library against each other on top of a fit: screened, the leaders fitted, the best first."""

from collections.abc import Sequence

import numpy as np

from fmus.effects import Effect
from identification.gap.naming.candidate import CLEAR, SIGNIFICANT, Candidate, adequate, one_each, ranked
from identification.gap.naming.fitted import Fit
from identification.gap.naming.fitting import lost
from identification.gap.naming.joining import contained, finished, fit_each
from identification.gap.naming.screening import Signature, screen

RIVAL = 0.15  # of an adequate effect's gain: what a rival must promise to be fitted
PLAIN = 0.3  # of that: an effect without shapes is fitted at once, and promises little where the base must move far for it
LEADING = 0.02  # of the most that is promised: what a leading family must promise
STARTS, MOST_STARTS = 2, 6  # signatures of a family that are fitted, and where nothing is adequate
NEAR = 0.5  # of the best one's dBIC: what a family must have for its other forms to be fitted, and to be the first of a pair
BEHIND, SHARE_BEHIND = 300.0, 0.25  # dBIC behind an adequate effect, or share of its dBIC, that another form of a family may make up for
FAR_LESS = 0.25  # of a gain: what a signature, which sees only small effects in full, must promise
HOPELESS = 10.0  # times the chi-square that is to be reached
CURVED = 5.0  # times the best chi-square: what a curve of its own may make up for
LEADERS = 6  # families that are fitted first
AS_GOOD = 1.0  # chi-square by which a form may be behind one that it contains, where both have ended in the same place


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


class _Field:
    """Those that compete: the families of a library that are not in the fit yet, with what the screening promises of each."""

    def __init__(self, found: Fit, library: Sequence[type[Effect]]):
        self.found = found
        present = {e.family for e in found.model.effects}
        by_family: dict[str, list[type[Effect]]] = {}
        for effect in library:
            if effect.family not in present:
                by_family.setdefault(effect.family, []).append(effect)
        self.forms = {name: sorted(forms, key=lambda e: (e.flexible, len(e.sought()))) for name, forms in by_family.items()}
        self.seen = screen(found, [form for forms in self.forms.values() for form in _plain(forms)], keep=MOST_STARTS)
        self.top = max((s.gain for s in self.seen), default=0.0)
        self.of_family = {name: sorted((s for s in self.seen if s.effect.family == name), key=lambda s: -s.gain) for name in self.forms}
        self.promised = {name: signatures[0].gain if signatures else 0.0 for name, signatures in self.of_family.items()}  # none where it cannot join
        # What a form promises that has more to bend says little of the fit: the simplest one says which family goes first.
        simplest = {name: max((s.gain for s in of if s.effect is self.forms[name][0]), default=0.0) for name, of in self.of_family.items()}
        self.order = sorted(self.forms, key=lambda name: (-simplest[name], -self.promised[name]))


def _compete(found: Fit, library: Sequence[type[Effect]], leaders: int, least: float, others: bool, beat: float, known: Sequence[Fit]) -> list[Candidate]:
    field = _Field(found, library)
    if not any(_hopeful(found, s, least) for s in field.seen):
        return ranked(Candidate.promised(found, s) for s in field.seen)
    led = fit_each(found, screen(found, _leading(found, library, known), keep=1), [], beat, known)
    candidates = _in_waves(field, led, leaders, others, beat, known)
    if candidates[0].fitted and candidates[0].fit.chi2 > HOPELESS * beat:  # no other form makes up for so much
        return candidates
    candidates = _in_other_forms(field, candidates, beat, known)
    if not adequate(candidates[0].fit):
        tried_at_all, before = field.order if others else field.order[:leaders], candidates[0]
        candidates = ranked([*candidates, *fit_each(found, _further_starts(field, candidates, tried_at_all, others), [], beat, [])])
        candidates = candidates if candidates[0] is before else _in_other_forms(field, candidates, beat, known)
    if not adequate(candidates[0].fit):  # a curve of its own only where no plain form fits
        candidates = _in_other_forms(field, candidates, beat, known, flexible=True)
    return finished(found, candidates) if adequate(candidates[0].fit) else candidates


def _hopeful(found: Fit, signature: Signature, least: float) -> bool:
    """Whether an effect may gain enough. What is missed beside an adequate effect is small, so that the screening sees it, and its price counts as well."""
    small = bool(found.model.effects) and adequate(found)
    needed = least + (len(signature.start) * float(np.log(found.count)) if small else 0.0)
    return signature.gain >= max(SIGNIFICANT / 2, FAR_LESS * needed)


def _in_waves(field: _Field, led: list[Candidate], leaders: int, others: bool, beat: float, known: Sequence[Fit]) -> list[Candidate]:
    """The families one after the other, with those that led the way: what the first ones gain decides which others are worth a fit."""
    found, candidates, settled = field.found, [*led], {c.effect for c in led}
    tried = field.order if others else field.order[:leaders]
    least = {name: max(SIGNIFICANT / 2, (LEADING if name in tried[:leaders] else RIVAL) * field.top) for name in tried}
    waves = [tried[:1], tried[1:3], tried[3:leaders], tried[leaders:]]
    while waves:
        enough = max((min(c.delta_chi2, field.promised[c.family]) for c in candidates if c.fitted and adequate(c.fit)), default=0.0)
        # What an adequate effect's rivals must promise is known: they are fitted side by side.
        wave, waves = ([name for each in waves for name in each], []) if enough else (waves[0], waves[1:])
        seen = {name: [s for s in field.of_family[name] if s.effect not in settled][:STARTS] for name in wave}
        worth = [s for name in wave for s in seen[name] if s.gain >= max(least[name], RIVAL * enough * (1.0 if s.effect.shapes() else PLAIN))]
        further = [s for s in _other_forms(field, ranked(candidates)) if s.effect.family not in wave] if enough else []
        candidates += fit_each(found, [*further, *worth], candidates, beat, known)
        begun = {s.effect.family for s in worth}
        candidates += [Candidate.promised(found, seen[name][0]) for name in wave if seen[name] and name not in begun]
    return ranked([*candidates, *(Candidate.promised(found, s) for s in field.seen if s.effect.family not in tried)])


def _near(candidates: Sequence[Candidate], within: float = np.inf) -> set[str]:
    """The families that came out best, or may be with another form; those within so many times the best chi-square."""
    best = candidates[0]
    candidates = [c for c in candidates if c.fit.chi2 <= within * best.fit.chi2]
    reach = max(BEHIND, SHARE_BEHIND * best.delta_bic) if adequate(best.fit) else np.inf
    first = {c.family for c in candidates[:4] if best.delta_bic - c.delta_bic < CLEAR and c.delta_bic > SIGNIFICANT}
    return first | {c.family for c in one_each(candidates)[:4] if c.delta_bic > max(SIGNIFICANT, NEAR * best.delta_bic, best.delta_bic - reach)}


def _in_other_forms(field: _Field, candidates: list[Candidate], beat: float, known: Sequence[Fit], flexible: bool = False) -> list[Candidate]:
    """The candidates with the other forms of the near families."""
    return ranked([*candidates, *fit_each(field.found, _other_forms(field, candidates, flexible), candidates, beat, known)])


def _other_forms(field: _Field, candidates: Sequence[Candidate], flexible: bool = False) -> list[Signature]:
    """The forms of the near families that were not fitted yet, or not as well as a form that they contain."""
    fits, near = [c.fit for c in candidates if c.fitted], _near(candidates, CURVED if flexible else np.inf)
    tried = {c.effect for c in candidates if c.fitted and c.fit.chi2 < contained(c.fit.model, fits) + AS_GOOD}
    more = [form for name, forms in field.forms.items() if name in near for form in forms if form.flexible == flexible and form not in tried]
    return screen(field.found, more, keep=1)


def _further_starts(field: _Field, candidates: Sequence[Candidate], families: Sequence[str], others: bool) -> list[Signature]:
    """From where else effects are fitted if none is adequate: a small step says nothing of what a mode further off would bring."""
    starts = [s for name in families for s in field.of_family[name][STARTS:] if s.gain > 0]
    if others and lost(field.found):  # nor what an effect brings that needs what the base has lost
        fitted = {c.family for c in candidates if c.fitted}
        starts += [s for name in families if name not in fitted for s in field.of_family[name][:1] if not s.effect.shapes()]
    return starts


def _leading(found: Fit, library: Sequence[type[Effect]], known: Sequence[Fit]) -> list[type[Effect]]:
    """The effect of the library that the latest of the known fits has beyond this one: what it reaches spares others a long way."""
    beyond = [set(other.model.effects) - set(found.model.effects) for other in known if set(other.model.effects) > set(found.model.effects)]
    return [effect for effects in beyond[-1:] if len(effects) == 1 for effect in effects if effect in library]


def _plain(forms: Sequence[type[Effect]]) -> list[type[Effect]]:
    """The forms of a family that stand for it: all that are not flexible, since a spring that drifts is not a damper that does.

    Those with a memory differ in the shape of their loop alone, and take long: the first one of them is enough.
    """
    plain = [form for form in forms if not form.flexible] or list(forms[:1])
    remembering = [form for form in plain if any(row.role == "state" for row in form.declared.values())]
    return [form for form in plain if form not in remembering[1:]]
