"""Candidate search: the effects of a library on top of a fit, screened, the leading ones fitted, the best first.

The constants bound the search effort; they do not decide verdicts (see `Criteria`).
"""

from collections.abc import Sequence

import numpy as np

from fmus.effects import Effect
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, adequate, one_each, ranked
from motofmi.gap.estimation.effect_fit import contained, fit_each, fitted_to_the_end
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import lost
from motofmi.gap.estimation.screening import Signature, screen

RIVAL = 0.15  # least screened gain of a rival that is fitted, over the gain of an adequate effect
# factor on RIVAL for effects without nonlinear parameters: their fits are cheap, and screening underestimates them
LINEAR = 0.3
LEADING = 0.02  # least screened gain of a leading family, over the largest one
STARTS, MOST_STARTS = 2, 6  # starts of a family that are fitted; the same where no candidate is adequate
NEAR = (
    0.5  # share of the best delta BIC from which a family's other forms are fitted, and it may be the first of a pair
)
BEHIND, SHARE_BEHIND = (
    300.0,
    0.25,
)  # delta BIC behind an adequate effect, absolute or as a share, within which other forms are fitted
SCREENED = 0.25  # least screened gain over the required one: screening is exact for small effects only
HOPELESS = 10.0  # ratio of chi-square to the one to be reached above which no other form is fitted
FLEXIBLE = 5.0  # ratio of chi-square to the best one up to which a flexible form is fitted
LEADERS = 6  # families that are fitted first
SAME_MINIMUM = 1.0  # chi-square within which a form has reached the minimum of a form that it contains


def search_candidates(found: Fit, library: Sequence[type[Effect]], leaders: int = LEADERS, least: float | None = None, others: bool = True,
            beat: float = np.inf, known: list[Fit] | None = None, criteria: Criteria = Criteria()) -> list[Candidate]:  # fmt: skip
    """The candidates on top of a fit: fitted ones before others, then by delta BIC.

    All families are screened. The leading ones (with `others` all) are fitted as far as their screened gain makes them
    rivals, and the best in all their forms. Nothing is fitted where the screened gain is far below `least` (by default
    that of a first effect), and slow fits far above the chi-square `beat` are ended early. The fits in `known` (of
    other noise or other forms) serve as starts, the latest first; new fits are added to it, the best last.
    """
    known = known if known is not None else []
    least = criteria.first_effect_delta_bic if least is None else least
    candidates = _search(found, library, leaders, least, others, beat, known, criteria)
    known += [c.fit for c in reversed(candidates) if c.fitted]
    return candidates


class _ScreenedLibrary:
    """The families of a library that are not in the fit yet, with the screened gain of each."""

    def __init__(self, found: Fit, library: Sequence[type[Effect]], criteria: Criteria):
        self.found, self.criteria = found, criteria
        present = {e.family for e in found.model.effects}
        by_family: dict[str, list[type[Effect]]] = {}
        for effect in library:
            if effect.family not in present:
                by_family.setdefault(effect.family, []).append(effect)
        self.forms = {
            name: sorted(forms, key=lambda e: (e.flexible, len(e.free_parameters())))
            for name, forms in by_family.items()
        }
        self.seen = screen(found, [form for forms in self.forms.values() for form in _plain(forms)], keep=MOST_STARTS)
        self.top = max((s.gain for s in self.seen), default=0.0)
        self.of_family = {
            name: sorted((s for s in self.seen if s.effect.family == name), key=lambda s: -s.gain)
            for name in self.forms
        }
        self.promised = {
            name: signatures[0].gain if signatures else 0.0 for name, signatures in self.of_family.items()
        }  # none where it cannot be added
        # A form with more parameters gains more in the screening than in the fit, so the simplest form decides
        # the order of families.
        simplest = {
            name: max((s.gain for s in of if s.effect is self.forms[name][0]), default=0.0)
            for name, of in self.of_family.items()
        }
        self.order = sorted(self.forms, key=lambda name: (-simplest[name], -self.promised[name]))


def _search(found: Fit, library: Sequence[type[Effect]], leaders: int, least: float, others: bool, beat: float, known: Sequence[Fit],
             criteria: Criteria) -> list[Candidate]:  # fmt: skip
    field = _ScreenedLibrary(found, library, criteria)
    if not any(_may_gain_enough(found, s, least, criteria) for s in field.seen):
        return ranked(Candidate.promised(found, s) for s in field.seen)
    led = fit_each(found, screen(found, _leading(found, library, known), keep=1), [], beat, known, criteria)
    candidates = _fit_in_stages(field, led, leaders, others, beat, known)
    if candidates[0].fitted and candidates[0].fit.chi2 > HOPELESS * beat:  # no other form gains so much
        return candidates
    candidates = _in_other_forms(field, candidates, beat, known)
    if not adequate(candidates[0].fit, criteria):
        tried_at_all, before = field.order if others else field.order[:leaders], candidates[0]
        candidates = ranked(
            [
                *candidates,
                *fit_each(found, _further_starts(field, candidates, tried_at_all, others), [], beat, [], criteria),
            ]
        )
        candidates = candidates if candidates[0] is before else _in_other_forms(field, candidates, beat, known)
    if not adequate(candidates[0].fit, criteria):  # a flexible form only where no other form fits
        candidates = _in_other_forms(field, candidates, beat, known, flexible=True)
    return fitted_to_the_end(found, candidates, criteria) if adequate(candidates[0].fit, criteria) else candidates


def _may_gain_enough(found: Fit, signature: Signature, least: float, criteria: Criteria) -> bool:
    """Whether an effect may gain enough. Beside an adequate effect the remaining misfit is small: screening is
    reliable there, and the BIC penalty of the further parameters is included."""
    small = bool(found.model.effects) and adequate(found, criteria)
    needed = least + (len(signature.start) * float(np.log(found.count)) if small else 0.0)
    return signature.gain >= max(criteria.first_effect_delta_bic / 2, SCREENED * needed)


def _fit_in_stages(
    field: _ScreenedLibrary, led: list[Candidate], leaders: int, others: bool, beat: float, known: Sequence[Fit]
) -> list[Candidate]:
    """The families fitted in stages: the gain of the first ones decides which others are fitted."""
    found, criteria, candidates, settled = field.found, field.criteria, [*led], {c.effect for c in led}
    tried = field.order if others else field.order[:leaders]
    least = {
        name: max(criteria.first_effect_delta_bic / 2, (LEADING if name in tried[:leaders] else RIVAL) * field.top)
        for name in tried
    }
    waves = [tried[:1], tried[1:3], tried[3:leaders], tried[leaders:]]
    while waves:
        enough = max(
            (min(c.delta_chi2, field.promised[c.family]) for c in candidates if c.fitted and adequate(c.fit, criteria)),
            default=0.0,
        )
        # Once an effect is adequate, the gain that its rivals need is known, and all are fitted in parallel.
        wave, waves = ([name for each in waves for name in each], []) if enough else (waves[0], waves[1:])
        seen = {name: [s for s in field.of_family[name] if s.effect not in settled][:STARTS] for name in wave}
        worth = [
            s
            for name in wave
            for s in seen[name]
            if s.gain >= max(least[name], RIVAL * enough * (1.0 if s.effect.nonlinear_parameters() else LINEAR))
        ]
        further = [s for s in _other_forms(field, ranked(candidates)) if s.effect.family not in wave] if enough else []
        candidates += fit_each(found, [*further, *worth], candidates, beat, known, criteria)
        begun = {s.effect.family for s in worth}
        candidates += [Candidate.promised(found, seen[name][0]) for name in wave if seen[name] and name not in begun]
    return ranked([*candidates, *(Candidate.promised(found, s) for s in field.seen if s.effect.family not in tried)])


def _near_families(candidates: Sequence[Candidate], criteria: Criteria, within: float = np.inf) -> set[str]:
    """The best families and those that may be best with another form, within a factor of the best chi-square."""
    best = candidates[0]
    candidates = [c for c in candidates if c.fit.chi2 <= within * best.fit.chi2]
    reach = max(BEHIND, SHARE_BEHIND * best.delta_bic) if adequate(best.fit, criteria) else np.inf
    least, lead = criteria.first_effect_delta_bic, criteria.clear_lead_delta_bic
    first = {c.family for c in candidates[:4] if best.delta_bic - c.delta_bic < lead and c.delta_bic > least}
    return first | {
        c.family
        for c in one_each(candidates)[:4]
        if c.delta_bic > max(least, NEAR * best.delta_bic, best.delta_bic - reach)
    }


def _in_other_forms(
    field: _ScreenedLibrary, candidates: list[Candidate], beat: float, known: Sequence[Fit], flexible: bool = False
) -> list[Candidate]:
    """The candidates, with further forms fitted of the families whose chi-square is near the best one."""
    return ranked(
        [
            *candidates,
            *fit_each(field.found, _other_forms(field, candidates, flexible), candidates, beat, known, field.criteria),
        ]
    )


def _other_forms(field: _ScreenedLibrary, candidates: Sequence[Candidate], flexible: bool = False) -> list[Signature]:
    """Forms of the near families that were not fitted yet, or ended above a form that they contain."""
    fits, near = (
        [c.fit for c in candidates if c.fitted],
        _near_families(candidates, field.criteria, FLEXIBLE if flexible else np.inf),
    )
    tried = {c.effect for c in candidates if c.fitted and c.fit.chi2 < contained(c.fit.model, fits) + SAME_MINIMUM}
    more = [
        form
        for name, forms in field.forms.items()
        if name in near
        for form in forms
        if form.flexible == flexible and form not in tried
    ]
    return screen(field.found, more, keep=1)


def _further_starts(
    field: _ScreenedLibrary, candidates: Sequence[Candidate], families: Sequence[str], others: bool
) -> list[Signature]:
    """Further starts where no effect is adequate: screening cannot estimate the gain of a mode far from its start."""
    starts = [s for name in families for s in field.of_family[name][STARTS:] if s.gain > 0]
    if others and lost(field.found):  # nor that of an effect that needs a vanished parameter of the base
        fitted = {c.family for c in candidates if c.fitted}
        starts += [
            s
            for name in families
            if name not in fitted
            for s in field.of_family[name][:1]
            if not s.effect.nonlinear_parameters()
        ]
    return starts


def _leading(found: Fit, library: Sequence[type[Effect]], known: Sequence[Fit]) -> list[type[Effect]]:
    """The effect that the latest known fit has in addition to this one; its chi-square lets other fits end early."""
    beyond = [
        set(other.model.effects) - set(found.model.effects)
        for other in known
        if set(other.model.effects) > set(found.model.effects)
    ]
    return [effect for effects in beyond[-1:] if len(effects) == 1 for effect in effects if effect in library]


def _plain(forms: Sequence[type[Effect]]) -> list[type[Effect]]:
    """The forms that represent a family in the screening: all that are not flexible.

    Of forms with states (hysteresis loops of different shape) only the first, since they take long to simulate.
    """
    plain = [form for form in forms if not form.flexible] or list(forms[:1])
    with_initial_guesses = [form for form in plain if any(row.role == "state" for row in form.declared.values())]
    return [form for form in plain if form not in with_initial_guesses[1:]]
