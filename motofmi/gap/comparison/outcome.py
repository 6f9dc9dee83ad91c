"""The outcome of a comparison: which effect is missing, from the model confidence set of base, effects and pairs.

    base in the set                           no effect is distinguishable from none
    single effects in the set                 named if they are of one family, tied otherwise
    only pairs in the set                     the families that all pairs share are named

A name needs also a gain on data that were not used whose 95 % interval is above zero, a share of the closable misfit
worth naming, and a magnitude that its error does not exceed. Whatever withholds a name is a sentence with its number.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from motofmi.gap.comparison.closable import Share, explained_share, log_gain_low
from motofmi.gap.comparison.confidence_set import confidence_set
from motofmi.gap.comparison.contender import Contender
from motofmi.gap.comparison.simplest_form import one_per_families
from motofmi.gap.criteria import Criteria


@dataclass(frozen=True)
class Outcome:
    """The verdict of a comparison: `named`, `tied`, `none` or `unknown`.

    best is the model that the verdict selects (the base for `none` and `unknown`), members the contenders that are
    named or tied, nearest the contender with the least loss, share what best (for `unknown`: nearest) closes.
    """

    verdict: str
    best: Contender
    members: list[Contender]
    nearest: Contender | None
    share: Share | None
    sentences: list[str] = field(default_factory=list)


def outcome(base: Contender, contenders: Sequence[Contender], flexible: float, motion: float, counts: tuple[int, int],
            errors: dict[int, np.ndarray], criteria: Criteria) -> Outcome:  # fmt: skip
    """The verdict from the base and its contenders.

    flexible is the mean square that a flexible regression leaves and motion that of the outputs, in the units of the
    contenders; counts are the blocks of fitted and validation runs; errors holds the standard errors of the fitted
    parameters by the id of a contender.
    """
    sentences, doubts = few_blocks(counts, criteria), {}
    for contender in contenders:
        if doubt := _doubt(base, contender, contenders, flexible, errors[id(contender)], criteria):
            doubts[id(contender)] = doubt
    every = [c for c in one_per_families(contenders) if c.losses.mean() < base.losses.mean()]
    gained = one_per_families([c for c in contenders if id(c) not in doubts])
    nearest = next(iter([*gained, *every]), None)
    unknown = Outcome(
        "unknown", base, [], nearest, explained_share(base, nearest, flexible) if nearest else None, sentences
    )
    closable = np.sqrt(max(float(base.held_out.mean()) - flexible, 0.0) / motion)
    if closable <= criteria.tolerance:
        sentences.append(f"The base misses {closable:.2%} of the motion (rms) beyond what a flexible model leaves, which is within the "
                         f"tolerance of {criteria.tolerance:.2%}.")  # fmt: skip
        return Outcome("none", base, [], nearest, None, sentences)
    if not gained:
        sentences += [doubts[id(c)] for c in every[:1]] or ["No effect of the library reduces the loss on blocks."]
        return unknown
    if too_few(counts, criteria):
        return unknown
    inside, p = confidence_set(np.array([base.losses, *(c.losses for c in gained)]), criteria.confidence_set_level)
    if 0 in inside:
        sentences.append(f"No effect is distinguishable from none: the base is in the model confidence set (p = {p[0]:.3f}, "
                         f"level {criteria.confidence_set_level:g}); nearest {_named(gained[0])}.")  # fmt: skip
        return unknown
    if every[0] is not gained[0] and id(every[0]) in doubts:
        sentences.append(doubts[id(every[0])])
    left = [gained[i - 1] for i in inside]
    fewest = min(len(c.effects) for c in left)
    members = _with_equal_ones([c for c in left if len(c.effects) == fewest], gained, base, flexible, criteria)
    best = min(members, key=lambda c: c.losses.mean())
    verdict = "named" if frozenset.intersection(*(c.families for c in members)) else "tied"
    return Outcome(verdict, best, members, gained[0], explained_share(base, best, flexible), sentences)


def few_blocks(counts: tuple[int, int], criteria: Criteria) -> list[str]:
    """The sentence on comparisons of few blocks."""
    fitted, validation = counts
    if fitted >= criteria.enough_blocks and (validation >= criteria.enough_blocks or not validation):
        return []
    return [f"The residuals give {fitted} independent blocks of fitted and {validation} of validation runs; from "
            f"{criteria.enough_blocks} of each on a comparison is reliable. Record longer runs."]  # fmt: skip


def too_few(counts: tuple[int, int], criteria: Criteria) -> bool:
    """Whether there are too few blocks for any verdict."""
    fitted, validation = counts
    return fitted < criteria.fewest_fitted_blocks or 0 < validation < criteria.fewest_validation_blocks


def _with_equal_ones(members: Sequence[Contender], gained: Sequence[Contender], base: Contender, flexible: float,
                     criteria: Criteria) -> list[Contender]:  # fmt: skip
    """The members, and contenders that close the same share of the closable misfit with no more parameters."""
    closable = max(float(base.held_out.mean()) - flexible, 1e-300)
    best = min(members, key=lambda c: c.losses.mean())
    near = [
        c
        for c in gained
        if len(c.effects) == len(best.effects)
        and c.parameters <= best.parameters
        and float(c.held_out.mean() - best.held_out.mean()) < criteria.equal_share * closable
    ]
    return list({id(c): c for c in (*members, *near)}.values())


def _doubt(base: Contender, member: Contender, contenders: Sequence[Contender], flexible: float, errors: np.ndarray,
           criteria: Criteria) -> str:  # fmt: skip
    """The sentence that withholds a name; empty where nothing does. A pair is compared with its better member alone."""
    name, before, closed = _named(member), base, "the closable misfit"
    if len(member.effects) > 1:
        alone = [c for c in contenders if len(c.effects) == 1 and c.families < member.families]
        before = min([base, *alone], key=lambda c: float(c.held_out.mean()))
        closed = f"what {_named(before) or 'the base'} leaves"
    if (low := log_gain_low(before, member)) <= 0:
        return (f"{name} is not named: its gain on data that were not used is not clear (95 % interval of the gain in "
                f"logarithmic loss from {low:.2g}).")  # fmt: skip
    share = explained_share(before, member, flexible)
    if share.share < criteria.least_share:
        return f"{name} is not named: it closes {share.share:.0%} of {closed}, less than {criteria.least_share:.0%}."
    model = member.fit.model
    for effect in member.effects:
        sizes = [
            model.names.index(model.experiment.parameter(effect, n))
            for n in effect.free_parameters()
            if n not in effect.nonlinear_parameters()
        ]
        if sizes and all(abs(member.fit.x[i]) < criteria.value_errors * errors[i] for i in sizes):
            i = sizes[0]
            return (f"{name} is not named: {model.names[i]} = {member.fit.x[i]:.3g} is within {criteria.value_errors:g} "
                    f"standard errors ({errors[i]:.2g}) of zero.")  # fmt: skip
    return ""


def _named(contender: Contender) -> str:
    return " and ".join(effect.family for effect in contender.effects)
