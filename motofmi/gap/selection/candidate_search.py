"""Candidate search: the effects of a library are screened on a fit, and the leading ones are fitted together with it.

The constants limit the effort of the search; the decision thresholds are in `Criteria`. A "gain" is a decrease of
chi-square, a "screened gain" is its linear estimate before any fit (see `estimation.screening`).
"""

from collections.abc import Sequence

import numpy as np

from fmus.effects import Effect
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, adequate, one_each, ranked
from motofmi.gap.estimation.effect_fit import contained, fit_each, fit_from_further_starts, fitted_to_the_end
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.estimation.fitting import has_vanished_parameter
from motofmi.gap.estimation.screening import Signature, screen

RIVAL_SHARE = 0.15  # least screened gain of a rival that is fitted, over the gain of an adequate effect
# Factor on RIVAL_SHARE for effects without nonlinear parameters: their fits are fast, and screening underestimates
# their gain.
LINEAR_EFFECT_FACTOR = 0.3
LEADING_SHARE = 0.02  # least screened gain of a leading family, over the largest one
STARTS = 2  # starts of a family that are fitted
MOST_STARTS = 6  # the same where no candidate is adequate
# Share of the best delta BIC from which a family's other forms are fitted, and from which it may be the first of a pair
NEAR_SHARE = 0.5
MOST_BEHIND = 300.0  # delta BIC behind an adequate effect within which other forms of a family are fitted
MOST_BEHIND_SHARE = 0.25  # the same as a share of the adequate effect's delta BIC
SCREENED_SHARE = 0.25  # least screened gain over the required gain: screening is exact for small effects only
OUT_OF_REACH = 10.0  # ratio of chi-square to the one to be reached above which no other form is fitted
FLEXIBLE_RATIO = 5.0  # ratio of chi-square to the best one up to which a flexible form is fitted
LEADERS = 6  # families that are fitted first
SAME_MINIMUM = 1.0  # chi-square within which a form has reached the minimum of a form that it contains


def search_candidates(
    found: Fit,
    library: Sequence[type[Effect]],
    leaders: int = LEADERS,
    least: float | None = None,
    others: bool = True,
    beat: float = np.inf,
    known: list[Fit] | None = None,
    criteria: Criteria = Criteria(),
) -> list[Candidate]:
    """The effects of a library as candidates beside those of a fit: fitted ones before others, then by delta BIC.

    All families are screened. The first `leaders` of them, with `others` all, are fitted where their screened gain is
    large enough for a rival; the best families are fitted in all their forms. Nothing is fitted where the largest
    screened gain is far below the delta BIC `least` (by default that of a first effect). Fits that cannot reach the
    chi-square `beat` are ended early. The fits in `known` (with other noise or other forms) serve as starts, the latest
    first; new fits are added to it, the best last.
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
        plain = [form for forms in self.forms.values() for form in _plain(forms)]
        self.signatures = screen(found, plain, keep=MOST_STARTS)
        self.top = max((s.gain for s in self.signatures), default=0.0)
        self.of_family = {
            name: sorted((s for s in self.signatures if s.effect.family == name), key=lambda s: -s.gain)
            for name in self.forms
        }
        self.promised = {
            name: signatures[0].gain if signatures else 0.0 for name, signatures in self.of_family.items()
        }
        # Screening overestimates the gain of a form with many parameters more than that of a simple one. Therefore
        # the simplest form determines the order of the families.
        simplest = {
            name: max((s.gain for s in of if s.effect is self.forms[name][0]), default=0.0)
            for name, of in self.of_family.items()
        }
        self.order = sorted(self.forms, key=lambda name: (-simplest[name], -self.promised[name]))


def _search(
    found: Fit,
    library: Sequence[type[Effect]],
    leaders: int,
    least: float,
    others: bool,
    beat: float,
    known: Sequence[Fit],
    criteria: Criteria,
) -> list[Candidate]:
    """The candidates of `search_candidates`; `known` is only read."""
    field = _ScreenedLibrary(found, library, criteria)
    if not any(_may_gain_enough(found, s, least, criteria) for s in field.signatures):
        return ranked(Candidate.promised(found, s) for s in field.signatures)
    earlier = screen(found, _added_by_latest(found, library, known), keep=1)
    fitted = fit_each(found, earlier, [], beat, known, criteria)
    candidates = _fit_in_stages(field, fitted, leaders, others, beat, known)
    if candidates[0].fitted and candidates[0].fit.chi2 > OUT_OF_REACH * beat:  # no other form has so large a gain
        return candidates
    candidates = _in_other_forms(field, candidates, beat, known)
    if not adequate(candidates[0].fit, criteria):
        families, before = field.order if others else field.order[:leaders], candidates[0]
        starts = _further_starts(field, candidates, families, others)
        near = found.chi2 - NEAR_SHARE * max(found.chi2 - before.fit.chi2, 0.0)
        candidates = ranked([*candidates, *fit_from_further_starts(found, starts, min(beat, near))])
        candidates = candidates if candidates[0] is before else _in_other_forms(field, candidates, beat, known)
    if not adequate(candidates[0].fit, criteria):  # a flexible form only where no other form fits
        candidates = _in_other_forms(field, candidates, beat, known, flexible=True)
    return fitted_to_the_end(found, candidates, criteria) if adequate(candidates[0].fit, criteria) else candidates


def _may_gain_enough(found: Fit, signature: Signature, least: float, criteria: Criteria) -> bool:
    """Whether the screened gain is large enough for a fit.

    Beside an adequate effect the remaining misfit is small. Screening is reliable there, so that the BIC penalty of the
    effect's parameters is part of the required gain.
    """
    small = bool(found.model.effects) and adequate(found, criteria)
    required = least + (len(signature.start) * float(np.log(found.count)) if small else 0.0)
    return signature.gain >= max(criteria.first_effect_delta_bic / 2, SCREENED_SHARE * required)


def _fit_in_stages(
    field: _ScreenedLibrary, fitted: list[Candidate], leaders: int, others: bool, beat: float, known: Sequence[Fit]
) -> list[Candidate]:
    """The families fitted in stages: the gain of the first ones determines which others are fitted.

    fitted are candidates that have a fit already.
    """
    found, criteria, candidates, done = field.found, field.criteria, [*fitted], {c.effect for c in fitted}
    families = field.order if others else field.order[:leaders]
    shares = {name: LEADING_SHARE if i < leaders else RIVAL_SHARE for i, name in enumerate(families)}
    least = {name: max(criteria.first_effect_delta_bic / 2, share * field.top) for name, share in shares.items()}
    stages = [families[:1], families[1:3], families[3:leaders], families[leaders:]]
    while stages:
        gained = max(
            (min(c.delta_chi2, field.promised[c.family]) for c in candidates if c.fitted and adequate(c.fit, criteria)),
            default=0.0,
        )
        # Once an effect is adequate, the gain that its rivals need is known, and all are fitted in parallel.
        stage, stages = ([name for each in stages for name in each], []) if gained else (stages[0], stages[1:])
        starts = {name: [s for s in field.of_family[name] if s.effect not in done][:STARTS] for name in stage}
        rivals = [
            s for name in stage for s in starts[name] if s.gain >= max(least[name], _gain_of_a_rival(s.effect, gained))
        ]
        forms = [s for s in _other_forms(field, ranked(candidates)) if s.effect.family not in stage] if gained else []
        candidates += fit_each(found, [*forms, *rivals], candidates, beat, known, criteria)
        begun = {s.effect.family for s in rivals}
        not_begun = [name for name in stage if starts[name] and name not in begun]
        candidates += [Candidate.promised(found, starts[name][0]) for name in not_begun]
    not_tried = [s for s in field.signatures if s.effect.family not in families]
    return ranked([*candidates, *(Candidate.promised(found, s) for s in not_tried)])


def _gain_of_a_rival(effect: type[Effect], gained: float) -> float:
    """The least screened gain with which an effect is fitted beside an adequate one that gained this chi-square."""
    return RIVAL_SHARE * gained * (1.0 if effect.nonlinear_parameters() else LINEAR_EFFECT_FACTOR)


def _near_families(candidates: Sequence[Candidate], criteria: Criteria, within: float = np.inf) -> set[str]:
    """The best families, and those that may be the best with another form.

    Only candidates whose chi-square is at most `within` times the best one count.
    """
    best = candidates[0]
    candidates = [c for c in candidates if c.fit.chi2 <= within * best.fit.chi2]
    behind = max(MOST_BEHIND, MOST_BEHIND_SHARE * best.delta_bic) if adequate(best.fit, criteria) else np.inf
    least, lead = criteria.first_effect_delta_bic, criteria.clear_lead_delta_bic
    near = max(least, NEAR_SHARE * best.delta_bic, best.delta_bic - behind)
    first = {c.family for c in candidates[:4] if best.delta_bic - c.delta_bic < lead and c.delta_bic > least}
    return first | {c.family for c in one_each(candidates)[:4] if c.delta_bic > near}


def _in_other_forms(
    field: _ScreenedLibrary, candidates: list[Candidate], beat: float, known: Sequence[Fit], flexible: bool = False
) -> list[Candidate]:
    """The candidates, with further forms fitted of the families whose chi-square is near the best one."""
    forms = _other_forms(field, candidates, flexible)
    return ranked([*candidates, *fit_each(field.found, forms, candidates, beat, known, field.criteria)])


def _other_forms(field: _ScreenedLibrary, candidates: Sequence[Candidate], flexible: bool = False) -> list[Signature]:
    """Forms of the near families that were not fitted yet, or ended above a form that they contain."""
    fits = [c.fit for c in candidates if c.fitted]
    near = _near_families(candidates, field.criteria, FLEXIBLE_RATIO if flexible else np.inf)
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
    """Further starts where no effect is adequate.

    Screening is not reliable for a mode whose frequency is far from its starting value. Where a parameter of the base
    is zero, it is not reliable either for effects that need this parameter.
    """
    starts = [s for name in families for s in field.of_family[name][STARTS:] if s.gain > 0]
    if others and has_vanished_parameter(field.found):
        fitted = {c.family for c in candidates if c.fitted}
        first = [s for name in families if name not in fitted for s in field.of_family[name][:1]]
        starts += [s for s in first if not s.effect.nonlinear_parameters()]
    return starts


def _added_by_latest(found: Fit, library: Sequence[type[Effect]], known: Sequence[Fit]) -> list[type[Effect]]:
    """The effect that the latest known fit has in addition to this one; with its chi-square other fits end early."""
    added = [
        set(other.model.effects) - set(found.model.effects)
        for other in known
        if set(other.model.effects) > set(found.model.effects)
    ]
    return [effect for effects in added[-1:] if len(effects) == 1 for effect in effects if effect in library]


def _plain(forms: Sequence[type[Effect]]) -> list[type[Effect]]:
    """The forms that represent a family in the screening: all that are not flexible and act at one element.

    Of forms with states (hysteresis loops of different shape) only the first is taken, since their simulation is slow.
    """
    plain = [form for form in forms if not (form.flexible or form.at_one)] or list(forms[:1])
    with_states = [form for form in plain if form.has_states()]
    return [form for form in plain if form not in with_states[1:]]
