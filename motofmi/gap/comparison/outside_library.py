"""Laws outside the library against the effects that a comparison selects.

The parameters of the library's effects have their physical signs, so that two of them can approximate one law that is
not in the library: a sensor whose gain falls and an asymmetric spring, for instance, the force of a degressive damper.
Where a law alone is sufficient by the one-standard-error rule (see `simplest_form`), nothing is named. A law must pass
the tests of gain, share and magnitude that a name must pass.
"""

from collections.abc import Sequence

from fmus.effects import Effect
from fmus.effects.added_terms import added_terms
from motofmi.gap.comparison.compared_model import CommonBlocks, ComparedModel
from motofmi.gap.comparison.objections import objection
from motofmi.gap.comparison.search import FAR_BEHIND
from motofmi.gap.comparison.simplest_form import simplest_sufficient, within_one_error
from motofmi.gap.estimation.fit_result import parameters_of_effect
from motofmi.gap.estimation.laws_outside_library import fitted_laws


def sufficient_law(
    selected: ComparedModel,
    base: ComparedModel,
    laws: Sequence[type[Effect]],
    flexible: float,
    blocks: CommonBlocks,
) -> ComparedModel | None:
    """The law that is sufficient in place of the effects of a model; None where there is none.

    laws are those outside the library, of which some are fitted together with the base; flexible [1] is the mean square
    after a flexible regression. A law must be sufficient on the fitted blocks alone, and then on all blocks.
    """
    beat = min(base.fit.chi2, FAR_BEHIND * selected.fit.chi2)
    to_beat = selected.fitted_losses
    fits = [
        found.fit
        for found in fitted_laws(base.fit, laws, beat, blocks.criteria)
        if (losses := blocks.fitted_losses(found.fit)) is not None and within_one_error(losses, to_beat)
    ]
    models = blocks.refined_and_evaluated(fits, "comparing laws outside the library")
    models = [
        m
        for m in models
        if objection(base, m, [], flexible, blocks.criteria) is None and not blocks.is_undetermined(m.fit, [base.fit])
    ]
    law = min(models, key=lambda m: m.losses.mean(), default=None)
    return law if law is not None and simplest_sufficient([selected, law]) is law else None


def with_values(law: ComparedModel) -> str:
    """The sentence of a law, with its equation and its value and standard error."""
    effect = law.effects[0]
    fitted = parameters_of_effect(law.fit, effect)
    values = ", ".join(f"{name} = {value:.4g} +- {error:.2g} {unit}" for name, (value, error, unit) in fitted.items())
    return f"{effect.sentence().rstrip('.')} ({'; '.join(added_terms(effect))}, {values})."
