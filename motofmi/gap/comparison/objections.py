"""Reasons not to name the effects of a compared model, each a standing and a sentence with its number.

A magnitude that is not distinguishable from zero; a mode or a change over time that the runs do not resolve; a gain on
data that were not used whose 95 % interval contains zero, or that closes less than `Criteria.least_share` of the
closable misfit; a delta BIC below `Criteria.first_effect_delta_bic`, of a second effect below
`Criteria.second_effect_delta_bic`.

    dBIC = n (mean logarithmic loss of the base - that of the model) - difference of penalties

n are the fitted data. This is the delta BIC of least squares with unknown variance, n ln(S_base / S_model) - k ln n
(Burnham, Anderson, Model Selection and Multimodel Inference, 2002, sections 2.2 and 6.4), with the mean over blocks.
"""

from collections.abc import Sequence

import numpy as np

from motofmi.gap.comparison.closable import closed_share, log_gain_low
from motofmi.gap.comparison.compared_model import ComparedModel
from motofmi.gap.comparison.unresolved_modes import unresolved_modes
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import magnitudes_at_bounds, undetermined_magnitude
from motofmi.gap.estimation.fitting import shape_at_bound

OVER_TIME = "drift"  # the family of changes over the time of a run
# What became of a compared model.
MEMBER, BEHIND, NOT_CLEAR, SMALL, UNDETERMINED, WITHHELD = (
    "in the confidence set", "behind", "gain not clear", "gain too small", "value not determined", "withheld",
)  # fmt: skip


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
    withheld, before, closed = not_named(model), base, "the closable misfit"
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
        closed = f"what {effects_of(before) or 'the base'} leaves"
        least = criteria.second_effect_delta_bic if before.effects else least
    if (low := log_gain_low(before, model)) <= 0:
        few = closed_share(before.out_of_sample, model.out_of_sample, flexible).low > 0
        return NOT_CLEAR, (
            f"{withheld}: the gain on data that were not used is not clear (95 % interval of the gain in "
            f"logarithmic loss, in which every block counts alike, from {low:.2g})."
            + (" The mean square falls in the blocks where it is largest, and not in most others." if few else "")
        )
    share = min(
        (closed_share(getattr(before, data), getattr(model, data), flexible) for data in ("out_of_sample", "reported")),
        key=lambda each: each.share,
    )
    if share.share < 0:
        return SMALL, (
            f"{withheld}: on data that were not used the mean square that is left is larger than that of "
            f"{effects_of(before) or 'the base'}."
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


def undetermined(model: ComparedModel, errors: np.ndarray, criteria: Criteria) -> str:
    """The sentence on a model with a magnitude that is not distinguishable from zero or at its bound, or with a shape
    at its bound; empty without one."""
    begin, values = f"{not_named(model)}, and the others are compared without {_it(model)}:", model.fit.model.values
    if at_bound := shape_at_bound(model.fit):
        name, end = at_bound
        return (
            f"{begin} {name} = {values(model.fit.shared)[name]:.3g} is at its {end} value, beyond which the effect is "
            "not distinguishable from another one."
        )
    if at_bounds := magnitudes_at_bounds(model.fit):
        name, value = next(iter(at_bounds.items()))
        return f"{begin} {name} = {value:.3g} is at its bound, so that the effect does not fit well."
    if (found := undetermined_magnitude(model.fit, errors, criteria)) is None:
        return ""
    name, value, error = found
    begin += f" beside {_it(model)}" if name in model.fit.model.base else ""
    if not np.isfinite(error):
        return f"{begin} {name} has no influence on these runs."
    within = f"{criteria.value_errors:g} standard errors (of {error:.2g} each)"
    return f"{begin} {name} = {value:.3g} is within {within} of zero."


def effects_of(model: ComparedModel) -> str:
    return " and ".join(effect.family for effect in model.effects)


def _it(model: ComparedModel) -> str:
    return "it" if len(model.effects) == 1 else "them"


def not_named(model: ComparedModel) -> str:
    return f"{effects_of(model)} {'is' if len(model.effects) == 1 else 'are'} not named"
