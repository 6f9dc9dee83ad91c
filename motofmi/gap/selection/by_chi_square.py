"""The verdict of fitted candidates by chi-square and BIC, before validation runs confirm or reject it."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import Candidate, adequate, best_of, one_each, ranked
from motofmi.gap.estimation.fit_result import Fit
from motofmi.gap.selection.pairs import Pair, shared_families
from motofmi.gap.selection.result import Verdict
from motofmi.gap.validation.validation_run import required_share


def of_one(base: Fit, first: list[Candidate], criteria: Criteria) -> Verdict:
    """The verdict from single effects."""
    verdict_of = partial(Verdict, criteria=criteria)
    best = best_of(first, criteria)
    if best is None:
        return verdict_of("unknown", base, base, candidates=first)
    if adequate(best.fit, criteria):
        tied = [
            c
            for c in one_each(first)
            if c.fitted and best.delta_bic - c.delta_bic < criteria.tie_delta_bic and adequate(c.fit, criteria)
        ]
        if len(tied) > 1:
            return verdict_of("tied", base, best.fit, [], tied, first)
        return verdict_of("named", base, best.fit, [best], [], first, best.effect.flexible)
    left = 1 - required_share(base, criteria.unspecified_form_closed_share, criteria)
    behind = rivals(best, first, criteria)
    if best.fit.reduced - 1 < left * (base.reduced - 1) and not behind:
        return verdict_of("named", base, best.fit, [best], [], first, unspecified_form=True)
    closed = 1 - (best.fit.reduced - 1) / (base.reduced - 1)
    why = (
        f"leads {behind[0].family} by a delta BIC of {best.delta_bic - behind[0].delta_bic:.3g}, less than "
        f"{criteria.clear_lead_delta_bic:g}"
        if closed > 1 - left
        else f"closes {closed:.0%} of the excess, less than {1 - left:.0%}"
    )
    withheld = f"No form of an effect is adequate, and {best.family} is not named without one: it {why}."
    return verdict_of("unknown", base, best.fit, candidates=first, withheld=withheld)


def rivals(best: Candidate, first: Sequence[Candidate], criteria: Criteria) -> list[Candidate]:
    """The candidates of other families that an effect does not lead clearly."""
    return [
        c
        for c in one_each(first)
        if c.family != best.family and best.delta_bic - c.delta_bic <= criteria.clear_lead_delta_bic
    ]


def of_pairs(base: Fit, found: Pair, pairs: Sequence[Pair], first: list[Candidate], criteria: Criteria) -> Verdict:
    """Both effects where all pairs are of the same families, the one with the larger delta BIC alone first; else the
    effect that all contain, with the others tied.

    The effect that all contain is not named where each of the others alone has a larger delta BIC.
    """
    families, alone = shared_families(pairs), {c.family: c.delta_bic for c in reversed(ranked(first))}
    if len(families) == 2:
        both = sorted(found.members, key=lambda c: -alone.get(c.family, -np.inf))
        return Verdict("named", base, found.second.fit, both, [], first, criteria=criteria)
    members = [c for pair in pairs for c in pair.members]
    certain = next(c for c in members if c.family in families)
    tied = [c for c in members if c.family not in families]
    if min(alone.get(c.family, -np.inf) for c in tied) > alone.get(certain.family, -np.inf):
        return Verdict("tied", base, found.second.fit, [], tied, first, criteria=criteria)
    return Verdict("named", base, found.second.fit, [certain], tied, first, criteria=criteria)
