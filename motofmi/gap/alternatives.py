"""The models between which a verdict does not decide: `alternatives` and `reason` of verdict.json."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fmus.effects.added_terms import added_terms
from motofmi.gap.comparison.closable import closed_share
from motofmi.gap.estimation.fit_result import Fit, parameters_of_effect, undetermined
from motofmi.gap.selection.result import Verdict


def alternatives(verdict: Verdict) -> list[dict[str, Any]]:
    """The members of a tie, or the nearest model where nothing is named; empty where all is named or nothing missing.

    Where the misfit is within the tolerance it is the model that would reduce it.

    Each has its effects with form, equations and parameters, and closed, the share of the closable misfit [1] that it
    closes on validation runs (without them: on blocks that are left out of the fit); None where chi-square decided.
    """
    found = verdict.comparison
    if found is None:
        fits = [c.fit for c in verdict.tied]
        if verdict.verdict == "unknown" and verdict.best.model.effects:
            fits = [verdict.best]
        return [_alternative(fit, None, verdict.criteria.value_errors) for fit in fits]
    models = found.outcome.members if verdict.tied else []
    if verdict.verdict in ("unknown", "none") and found.outcome.nearest:
        models = [found.outcome.nearest]
    return [
        _alternative(
            model.fit,
            closed_share(found.base.reported, model.reported, found.flexible_mean_square).share,
            verdict.criteria.value_errors,
        )
        for model in models
    ]


def reason(verdict: Verdict, limitations: Sequence[str]) -> str | None:
    """The sentence on the rule by which nothing is named; None where something is, nothing is missing, or the search
    was ended.

    limitations are the sentences of the verdict on its effects, the last of which decides where no other rule does.
    """
    if verdict.verdict != "unknown" or verdict.ended:
        return None
    decides = verdict.comparison.outcome.sentences if verdict.comparison else limitations
    return verdict.withheld or next(iter(decides[-1:]), None)


def _alternative(found: Fit, closed: float | None, errors: float) -> dict[str, Any]:
    effects = []
    for effect in found.model.effects:
        own = parameters_of_effect(found, effect)
        parameters = with_errors({n: p for n, p in own.items() if n not in undetermined(own, errors)})
        effects.append({"name": effect.family, "form": effect.form, "equations": added_terms(effect),
                        "sentence": effect.sentence(), "parameters": parameters})  # fmt: skip
    return {"effects": effects, "closed": closed}


def with_errors(parameters: Mapping[str, tuple[float, float, str]]) -> dict[str, dict[str, Any]]:
    """Parameters under the keys of the file, from value, standard error and unit.

    The error of a parameter without influence on the data is None.
    """
    return {
        n: {"value": v, "standard_error": e if np.isfinite(e) else None, "unit": u}
        for n, (v, e, u) in parameters.items()
    }

