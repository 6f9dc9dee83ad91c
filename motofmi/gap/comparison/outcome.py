"""The outcome of a comparison: which effect is missing, from the model confidence set of base, effects and pairs.

    base in the set                           no effect is distinguishable from none
    single effects in the set                 named if they are of one family, tied otherwise
    only pairs in the set                     the families that all pairs share are named, unless each other family
                                              explains more alone

Models with a magnitude that is not distinguishable from zero leave first, so that the others are compared without them.
Those with an objection (see `objections`) are not accepted. The library as a whole must be better than the base, on the
fitted runs and on the validation runs alone: of many effects, one gains by chance. Each reason not to name an effect is
a sentence with its number in `limitations`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from motofmi.gap.comparison.closable import Share, closed_share, closes_as_much
from motofmi.gap.comparison.compared_model import ComparedModel
from motofmi.gap.comparison.confidence_set import confidence_set
from motofmi.gap.comparison.objections import (
    BEHIND,
    MEMBER,
    UNDETERMINED,
    effects_of,
    not_named,
    objection,
    undetermined,
)
from motofmi.gap.comparison.simplest_form import one_per_families, without_undetermined_additions
from motofmi.gap.comparison.superior_ability import superior_ability
from motofmi.gap.criteria import Criteria

WEAKER = (
    "{} is in all tied models and is not named: alone it explains less than each of the effects between which the data "
    "do not decide ({})."
)
FEW_BLOCKS_SHARE = (
    "The 95 % interval of the closed share contains zero: the mean square is mostly that of a few blocks. The verdict "
    "rests on the gain in logarithmic loss per block, whose 95 % interval is above zero."
)


@dataclass(frozen=True)
class Outcome:
    """The verdict of a comparison: `named`, `tied`, `none` or `unknown`.

    best is the model that the verdict selects (the base for `none` and `unknown`), members are the models that are
    named or tied, nearest is the model with the least loss (for `none`: without objections), share is the share of the
    closable misfit that best (for `unknown`: nearest) closes, and sentences are limitations. standing holds what became
    of each model, by its id (see `objections`). disagreement is the limitation that nothing is named because the runs
    disagree on the base.
    """

    verdict: str
    best: ComparedModel
    members: list[ComparedModel]
    nearest: ComparedModel | None
    share: Share | None
    sentences: list[str] = field(default_factory=list)
    standing: dict[int, str] = field(default_factory=dict)
    disagreement: str = ""


@dataclass(frozen=True)
class _Compared:
    """The base and the other models of a comparison, with what speaks against each; arguments as those of `outcome`."""

    base: ComparedModel
    models: Sequence[ComparedModel]
    flexible: float
    errors: dict[int, np.ndarray]
    criteria: Criteria

    @cached_property
    def undetermined(self) -> dict[int, str]:
        """The sentences on models with a magnitude that is not distinguishable from zero, by id."""
        found = {id(m): undetermined(m, self.errors[id(m)], self.criteria) for m in self.models}
        return {key: sentence for key, sentence in found.items() if sentence}

    @cached_property
    def determined(self) -> list[ComparedModel]:
        return [m for m in self.models if id(m) not in self.undetermined]

    @cached_property
    def objections(self) -> dict[int, tuple[str, str]]:
        """The standings and sentences on determined models with an objection, by id."""
        found = {id(m): objection(self.base, m, self.models, self.flexible, self.criteria) for m in self.determined}
        return {key: why for key, why in found.items() if why}

    @cached_property
    def accepted(self) -> list[ComparedModel]:
        """The determined models without objection, one form of each, by their loss."""
        unopposed = [m for m in self.determined if id(m) not in self.objections]
        return one_per_families(without_undetermined_additions(unopposed, self.errors, self.criteria))

    @cached_property
    def better(self) -> list[ComparedModel]:
        """The determined models with less loss than the base, one form of each, by their loss."""
        return self._better_than_base(self.determined)

    @cached_property
    def only_undetermined(self) -> list[ComparedModel]:
        """The same of undetermined models of which no form is determined."""
        known = {m.families for m in self.determined}
        return self._better_than_base(
            [m for m in self.models if id(m) in self.undetermined and m.families not in known]
        )

    def _better_than_base(self, models: Sequence[ComparedModel]) -> list[ComparedModel]:
        return [m for m in one_per_families(models) if m.losses.mean() < self.base.losses.mean()]

    @property
    def standing(self) -> dict[int, str]:
        """What became of each model before the confidence set, by its id."""
        found = dict.fromkeys(map(id, self.models), BEHIND) | dict.fromkeys(self.undetermined, UNDETERMINED)
        return found | {key: kind for key, (kind, _) in self.objections.items()}

    def undetermined_ahead(self) -> list[str]:
        """The sentences on undetermined models with less loss than all accepted ones, that on the least loss last: the
        last sentence is the reason of an `unknown`."""
        least = self.accepted[0].losses.mean() if self.accepted else np.inf
        return [self.undetermined[id(m)] for m in reversed(self.only_undetermined) if m.losses.mean() < least]

    def within_tolerance(self, motion: float) -> str:
        """The sentence where the base misses no more than the tolerance; empty otherwise."""
        closable = np.sqrt(max(float(self.base.out_of_sample.mean()) - self.flexible, 0.0) / motion)
        if closable > self.criteria.tolerance:
            return ""
        return (
            f"The base misses {closable:.2%} of the motion (rms) beyond what a flexible model leaves, which is within "
            f"the tolerance of {self.criteria.tolerance:.2%}."
        )

    def why_none_is_accepted(self) -> list[str]:
        if self.better or self.only_undetermined:
            return [self.objections[id(m)][1] for m in self.better[:1]]
        return ["No effect of the library reduces the loss on blocks."]

    def why_the_best_is_not_named(self, blocks: int, inside: Sequence[int], base_p: float) -> str:
        """The sentence where there are too few blocks of fitted runs, the base is in the confidence set with this p
        value, or the gain may be chance; empty otherwise."""
        best, criteria = self.accepted[0], self.criteria
        if blocks < criteria.fewest_fitted_blocks:
            return (
                f"{not_named(best)}: a name needs {criteria.fewest_fitted_blocks} independent blocks of fitted runs, "
                f"and there are {blocks}. Give more or longer runs."
            )
        if 0 in inside:
            return (
                "No effect is distinguishable from none: the base is in the model confidence set "
                f"(p = {base_p:.3f}, level {criteria.confidence_set_level:g}); nearest {effects_of(best)}."
            )
        chance = _may_be_chance(self.base, self.determined, criteria)
        return f"{chance}; nearest {effects_of(best)}." if chance else ""


def outcome(
    base: ComparedModel,
    models: Sequence[ComparedModel],
    flexible: float,
    motion: float,
    counts: tuple[int, int],
    errors: dict[int, np.ndarray],
    criteria: Criteria,
) -> Outcome:
    """The verdict from the base and the other compared models.

    flexible [1] is the mean square after a flexible regression and motion [1] that of the outputs, over the squared
    scale of the comparison; counts are the blocks of fitted and of validation runs; errors holds the standard errors
    (parameters,) by which magnitudes are compared with zero, by the id of a model.
    """
    of = _Compared(base, models, flexible, errors, criteria)
    accepted, sentences = of.accepted, [*few_blocks(counts, criteria), *of.undetermined_ahead()]
    if sentence := of.within_tolerance(motion):
        sentences.append(sentence)
        return Outcome("none", base, [], next(iter(accepted), None), None, sentences, of.standing)
    nearest = next(iter([*accepted, *of.better, *of.only_undetermined]), None)
    share = closed_share(base.reported, nearest.reported, flexible) if nearest else None
    unknown = Outcome("unknown", base, [], nearest, share, sentences, of.standing)
    if not accepted:
        sentences += of.why_none_is_accepted()
        return unknown
    inside, p = confidence_set(np.array([base.losses, *(m.losses for m in accepted)]), criteria.confidence_set_level)
    if sentence := of.why_the_best_is_not_named(counts[0], inside, p[0]):
        sentences.append(sentence)
        return unknown
    return _named_or_tied(of, [accepted[i - 1] for i in inside], sentences)


def _named_or_tied(of: _Compared, inside: Sequence[ComparedModel], sentences: list[str]) -> Outcome:
    """The verdict from the models of a confidence set without the base, to the sentences of which it adds."""
    # The sufficient form of a family may have more loss than the base, so that no model need be better.
    ahead = next(iter(of.better), of.accepted[0])
    if ahead is not of.accepted[0] and id(ahead) in of.objections:
        sentences.append(of.objections[id(ahead)][1])
    fewest = min(len(m.effects) for m in inside)
    alone = [m for m in inside if len(m.effects) == fewest]
    members = _with_equal_ones(alone, of.accepted, of.base, of.flexible, of.criteria)
    if added := members[len(alone) :]:
        sentences.append(
            f"{' and '.join(effects_of(m) for m in added)} {'is' if len(added) == 1 else 'are'} tied: as much of the "
            f"closable misfit is closed (at most {of.criteria.equal_share:.0%} less), with no more parameters."
        )
    best = min(members, key=lambda m: m.losses.mean())
    common = frozenset.intersection(*(m.families for m in members))
    if common and (others := _weaker_alone(common, members, of.models)):
        sentences.append(WEAKER.format(" and ".join(common), " or ".join(sorted(others))))
        common = frozenset()
    share = closed_share(of.base.reported, best.reported, of.flexible)
    if share.low <= 0 < share.share:
        sentences.append(FEW_BLOCKS_SHARE)
    standing = of.standing | dict.fromkeys(map(id, members), MEMBER)
    return Outcome("named" if common else "tied", best, members, of.accepted[0], share, sentences, standing)


def _weaker_alone(
    common: frozenset[str], members: Sequence[ComparedModel], models: Sequence[ComparedModel]
) -> frozenset[str]:
    """The other families of the members, where each of them alone has less loss than what the members have in common;
    empty otherwise."""
    alone = {m.families: float(m.losses.mean()) for m in one_per_families(models) if len(m.effects) == 1}
    others = frozenset().union(*(m.families for m in members)) - common
    losses = [alone.get(frozenset((family,)), np.inf) for family in others]
    return others if losses and max(losses) < alone.get(common, np.inf) else frozenset()


def few_blocks(counts: tuple[int, int], criteria: Criteria) -> list[str]:
    """The limitation where there are few blocks of fitted or of validation runs; empty where there are enough."""
    fitted, validation = counts
    if fitted >= criteria.enough_blocks and (validation >= criteria.enough_blocks or not validation):
        return []
    together = " The validation runs are judged together with the left-out blocks of the fitted runs."
    return [
        f"The residuals give {fitted} independent blocks of fitted and {validation} of validation runs; from "
        f"{criteria.enough_blocks} of each on a comparison is reliable. Record longer runs."
        + (together if 0 < validation < criteria.fewest_validation_blocks else "")
    ]


def _may_be_chance(base: ComparedModel, models: Sequence[ComparedModel], criteria: Criteria) -> str:
    """The sentence where the largest gain of all models, on fitted or on validation runs, may be chance; empty
    otherwise."""
    for runs in ("fitted", "validation") if base.judged_alone else ("fitted",):
        losses = np.log(np.array([getattr(model, runs) for model in (base, *models)]) + base.floor)
        if losses.size and (p := superior_ability(losses[0], losses[1:])) >= criteria.confidence_set_level:
            return (
                f"No effect is named: on {runs} runs the largest gain of {len(models)} models is consistent with "
                f"chance (p = {p:.3f}, level {criteria.confidence_set_level:g})"
            )
    return ""


def _with_equal_ones(
    members: Sequence[ComparedModel],
    accepted: Sequence[ComparedModel],
    base: ComparedModel,
    flexible: float,
    criteria: Criteria,
) -> list[ComparedModel]:
    """The members, and models that close as much of the closable misfit with no more effects and parameters.

    A single effect does not tie with a pair that contains it.
    """
    best = min(members, key=lambda m: m.losses.mean())
    near = [
        m
        for m in accepted
        if len(m.effects) <= len(best.effects)
        and not m.families < best.families
        and closes_as_much(m, best, base, flexible, criteria.equal_share)
    ]
    return list({id(m): m for m in (*members, *near)}.values())
