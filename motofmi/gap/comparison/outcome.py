"""The outcome of a comparison: which effect is missing, from the model confidence set of base, effects and pairs.

    base in the set                           no effect is distinguishable from none
    single effects in the set                 named if they are of one family, tied otherwise
    only pairs in the set                     the families that all pairs share are named, unless each other family
                                              explains more alone

Models with a magnitude that is not distinguishable from zero leave first, so that the others are compared without them.
The library as a whole must be better than the base, on the fitted runs and on the validation runs alone: of many
effects, one gains by chance. A named effect must also have a gain on data that were not used whose 95 % interval is
above zero, close at least `Criteria.least_share` of the closable misfit, and have a delta BIC of at least
`Criteria.first_effect_delta_bic`, a second effect of at least `Criteria.second_effect_delta_bic`. Each reason not to
name an effect is a sentence with its number in `limitations`.

    dBIC = n (mean logarithmic loss of the base - that of the model) - difference of penalties

n are the fitted data. This is the delta BIC of least squares with unknown variance, n ln(S_base / S_model) - k ln n
(Burnham, Anderson, Model Selection and Multimodel Inference, 2002, sections 2.2 and 6.4), with the mean over blocks.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from motofmi.gap.comparison.closable import Share, closed_share, closes_as_much, log_gain_low
from motofmi.gap.comparison.compared_model import ComparedModel
from motofmi.gap.comparison.confidence_set import confidence_set
from motofmi.gap.comparison.simplest_form import one_per_families
from motofmi.gap.comparison.superior_ability import superior_ability
from motofmi.gap.comparison.unresolved_modes import unresolved_modes
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import undetermined_magnitude
from motofmi.gap.estimation.fitting import shape_at_bound

OVER_TIME = "drift"  # the family of changes over the time of a run
WEAKER = (
    "{} is in all tied models and is not named: alone it explains less than each of the effects between which the data "
    "do not decide ({})."
)
MEMBER, BEHIND, NOT_CLEAR, SMALL, UNDETERMINED, WITHHELD = STANDINGS = (
    "in the confidence set", "behind", "gain not clear", "gain too small", "value not determined", "withheld",
)  # fmt: skip


@dataclass(frozen=True)
class Outcome:
    """The verdict of a comparison: `named`, `tied`, `none` or `unknown`.

    best is the model that the verdict selects (the base for `none` and `unknown`), members are the models that are
    named or tied, nearest is the model with the least loss (for `none`: without objections), share is the share of the
    closable misfit that best (for `unknown`: nearest) closes, and sentences are limitations. standing holds what became
    of each model, by its id: one of `STANDINGS`. disagreement is the limitation that nothing is named because the runs
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
    sentences = few_blocks(counts, criteria)
    undetermined = {id(m): s for m in models if (s := _undetermined(m, errors[id(m)], criteria))}
    determined = [m for m in models if id(m) not in undetermined]
    objections = {id(m): why for m in determined if (why := objection(base, m, models, flexible, criteria))}
    standing = dict.fromkeys(map(id, models), BEHIND) | dict.fromkeys(undetermined, UNDETERMINED)
    standing |= {key: kind for key, (kind, _) in objections.items()}
    known = {m.families for m in determined}
    better, without = (
        [m for m in one_per_families(some) if m.losses.mean() < base.losses.mean()]
        for some in (determined, [m for m in models if id(m) in undetermined and m.families not in known])
    )
    accepted = one_per_families([m for m in determined if id(m) not in objections])
    nearest = next(iter([*accepted, *better, *without]), None)
    least = accepted[0].losses.mean() if accepted else np.inf
    sentences += [undetermined[id(m)] for m in without if m.losses.mean() < least]
    share = closed_share(base.reported, nearest.reported, flexible) if nearest else None
    unknown = Outcome("unknown", base, [], nearest, share, sentences, standing)
    closable = np.sqrt(max(float(base.out_of_sample.mean()) - flexible, 0.0) / motion)
    if closable <= criteria.tolerance:
        sentences.append(
            f"The base misses {closable:.2%} of the motion (rms) beyond what a flexible model leaves, which is within "
            f"the tolerance of {criteria.tolerance:.2%}."
        )
        return Outcome("none", base, [], next(iter(accepted), None), None, sentences, standing)
    if not accepted:
        sentences += [objections[id(m)][1] for m in better[:1]]
        if not (better or without):
            sentences.append("No effect of the library reduces the loss on blocks.")
        return unknown
    if counts[0] < criteria.fewest_fitted_blocks:
        sentences.append(
            f"{_not_named(accepted[0])}: a name needs {criteria.fewest_fitted_blocks} independent blocks of fitted "
            f"runs, and there are {counts[0]}. Give more or longer runs."
        )
        return unknown
    inside, p = confidence_set(np.array([base.losses, *(m.losses for m in accepted)]), criteria.confidence_set_level)
    if 0 in inside:
        sentences.append(
            "No effect is distinguishable from none: the base is in the model confidence set "
            f"(p = {p[0]:.3f}, level {criteria.confidence_set_level:g}); nearest {_effects_of(accepted[0])}."
        )
        return unknown
    if sentence := _may_be_chance(base, determined, criteria):
        sentences.append(f"{sentence}; nearest {_effects_of(accepted[0])}.")
        return unknown
    if better[0] is not accepted[0] and id(better[0]) in objections:
        sentences.append(objections[id(better[0])][1])
    not_eliminated = [accepted[i - 1] for i in inside]
    fewest = min(len(m.effects) for m in not_eliminated)
    members = [m for m in not_eliminated if len(m.effects) == fewest]
    equal = _with_equal_ones(members, accepted, base, flexible, criteria)
    if added := equal[len(members) :]:
        sentences.append(
            f"{' and '.join(_effects_of(m) for m in added)} {'is' if len(added) == 1 else 'are'} tied: as much of the "
            f"closable misfit is closed (at most {criteria.equal_share:.0%} less), with no more parameters."
        )
    members = equal
    best = min(members, key=lambda m: m.losses.mean())
    common = frozenset.intersection(*(m.families for m in members))
    if common and (others := _weaker_alone(common, members, models)):
        sentences.append(WEAKER.format(" and ".join(common), " or ".join(sorted(others))))
        common = frozenset()
    verdict = "named" if common else "tied"
    share = closed_share(base.reported, best.reported, flexible)
    if share.low <= 0 < share.share:
        sentences.append(
            "The 95 % interval of the closed share contains zero: the mean square is mostly that of a few blocks. The "
            "verdict rests on the gain in logarithmic loss per block, whose 95 % interval is above zero."
        )
    standing |= dict.fromkeys(map(id, members), MEMBER)
    return Outcome(verdict, best, members, accepted[0], share, sentences, standing)


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


def objection(
    base: ComparedModel,
    model: ComparedModel,
    models: Sequence[ComparedModel],
    flexible: float,
    criteria: Criteria,
) -> tuple[str, str] | None:
    """The reason not to name the effects of a model, as a standing and in a sentence; None where there is none.

    A pair is compared with the better of its two effects alone.
    """
    withheld, before, closed = _not_named(model), base, "the closable misfit"
    least = criteria.first_effect_delta_bic
    if OVER_TIME in model.families and (why := _confounded_with_time(model)):
        return NOT_CLEAR, f"{withheld}: {why}"
    if (modes := unresolved_modes(model.fit)) is not None:
        return NOT_CLEAR, (
            f"{withheld}: no run has an input, and none is long enough to resolve {modes}: together they are not "
            "distinguishable from a single one that changes with the amplitude. Give a run with an input."
        )
    if not model.judged_alone and len(model.validation) and model.validation_loss >= base.validation_loss:
        return NOT_CLEAR, f"{withheld}: the loss on the validation runs is not reduced."
    if len(model.effects) > 1:
        alone = [m for m in models if len(m.effects) == 1 and m.families < model.families]
        before = min([base, *alone], key=lambda m: float(m.out_of_sample.mean()))
        closed = f"what {_effects_of(before) or 'the base'} leaves"
        least = criteria.second_effect_delta_bic if before.effects else least
    if (low := log_gain_low(before, model)) <= 0:
        return NOT_CLEAR, (
            f"{withheld}: the gain on data that were not used is not clear (95 % interval of the gain in "
            f"logarithmic loss from {low:.2g})."
        )
    share = min(
        (closed_share(getattr(before, data), getattr(model, data), flexible) for data in ("out_of_sample", "reported")),
        key=lambda each: each.share,
    )
    if share.share < 0:
        return SMALL, (
            f"{withheld}: on data that were not used the mean square that is left is larger than that of "
            f"{_effects_of(before) or 'the base'}."
        )
    if share.share < criteria.least_share:
        return SMALL, f"{withheld}: {share.share:.0%} of {closed} is closed, less than {criteria.least_share:.0%}."
    if (gain := _delta_bic(before, model)) < least:
        return SMALL, f"{withheld}: the delta BIC on the fitted blocks is {gain:.3g}, less than {least:g}."
    return None


def _confounded_with_time(model: ComparedModel) -> str:
    """Why a change over time is confounded with another effect in these runs, and which runs would show it; empty where
    it is not."""
    runs = model.fit.runs
    if joined := next((run.recording.joined for run in runs if run.recording.joined), ()):
        return (
            f"{', '.join(joined)} are short and joined into one recording, so that its time is the order in which they "
            "are given. Give longer runs."
        )
    if not len(model.validation) and len(runs) < 2:
        return (
            "in a single run a change over time is not distinguishable from an effect of another kind. Give a second "
            "run, fitted or with --holdout."
        )
    return ""


def _delta_bic(before: ComparedModel, model: ComparedModel) -> float:
    """The delta BIC of a model on the blocks of the fitted runs, with the variance of each block unknown."""
    gain = np.mean(before.fitted_losses - model.fitted_losses)
    return float(model.fit.count * gain - (model.fit.penalty - before.fit.penalty))


def _undetermined(model: ComparedModel, errors: np.ndarray, criteria: Criteria) -> str:
    """The sentence on a model with a magnitude that is not distinguishable from zero, or with a shape at its bound;
    empty without one."""
    if at_bound := shape_at_bound(model.fit):
        name, end = at_bound
        return (
            f"{_not_named(model)}, and the others are compared without {_it(model)}: {name} = "
            f"{model.fit.model.values(model.fit.shared)[name]:.3g} is at its {end} value, beyond which the effect is "
            "not distinguishable from another one."
        )
    if (found := undetermined_magnitude(model.fit, errors, criteria)) is None:
        return ""
    name, value, error = found
    beside = f"beside {_it(model)} " if name in model.fit.model.base else ""
    return (
        f"{_not_named(model)}, and the others are compared without {_it(model)}: {beside}{name} = {value:.3g} is "
        f"within {criteria.value_errors:g} standard errors (of {error:.2g} each) of zero."
    )


def _effects_of(model: ComparedModel) -> str:
    return " and ".join(effect.family for effect in model.effects)


def _it(model: ComparedModel) -> str:
    return "it" if len(model.effects) == 1 else "them"


def _not_named(model: ComparedModel) -> str:
    return f"{_effects_of(model)} {'is' if len(model.effects) == 1 else 'are'} not named"
