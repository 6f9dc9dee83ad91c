"""The table of a comparison on blocks: `compared` of verdict.json, and the column `validation` of its candidates."""

from dataclasses import asdict
from typing import Any

from motofmi.gap.comparison.closable import closed_share
from motofmi.gap.selection.result import Verdict


def compared(verdict: Verdict) -> list[dict[str, Any]]:
    """The models that were compared on blocks, the least mean loss first; empty where chi-square decided.

    effects are the families and forms of a model, none for the base. loss_fitted and loss_validation are mean
    logarithmic losses on blocks [1], the latter None without validation runs. closed is the share of the closable
    misfit on validation runs [1] (without them: on blocks that are left out of the fit) with the ends of its 95 %
    interval, and standing is what became of the model.
    """
    found = verdict.comparison
    if found is None:
        return []
    base, standing = found.base, found.outcome.standing
    rows = []
    for model in sorted((*found.models, base), key=lambda m: m.losses.mean()):
        closed = closed_share(base.reported, model.reported, found.flexible_mean_square)
        rows.append({
            "effects": [{"name": e.family, "form": e.form} for e in model.effects],
            "loss_fitted": float(model.fitted_losses.mean()),
            "loss_validation": model.validation_loss if len(model.validation) else None,
            "closed": None if model is base else asdict(closed),
            "standing": "base" if model is base else standing[id(model)],
        })  # fmt: skip
    return rows


def closed_alone(verdict: Verdict) -> dict[tuple[str, str], float]:
    """The share of the closable misfit on validation runs [1] that a single effect closes, by its family and form.

    Only effects that were evaluated on validation runs are there: those of a comparison on blocks that has any.
    """
    found = verdict.comparison
    if found is None or not len(found.base.validation):
        return {}
    return {
        (model.effects[0].family, model.effects[0].form): closed_share(
            found.base.validation, model.validation, found.flexible_mean_square
        ).share
        for model in found.models
        if len(model.effects) == 1
    }
