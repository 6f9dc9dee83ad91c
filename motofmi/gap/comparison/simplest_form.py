"""The form of an effect: the simplest one whose mean loss is within one standard error of the best form's.

Where all magnitudes that a form adds to another one are indistinguishable from zero, it is that other form. It is left
out: where its mean loss is smaller, the values of the base are in another local minimum.

Source: the one-standard-error rule of Breiman, Friedman, Olshen, Stone, Classification and Regression Trees (1984),
section 3.4.3, with the standard error of the paired differences of losses.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from motofmi.gap.comparison.block_losses import standard_error
from motofmi.gap.comparison.compared_model import ComparedModel
from motofmi.gap.criteria import Criteria
from motofmi.gap.estimation.candidate import magnitudes_of
from motofmi.gap.estimation.fit_result import parameters_of, undetermined


def simplest_sufficient(forms: Sequence[ComparedModel]) -> ComparedModel:
    """The model with the fewest parameters among those within one standard error of the one with the least loss."""
    best = min(forms, key=lambda c: c.losses.mean())
    near = [c for c in forms if within_one_error(c.losses, best.losses)]
    fewest = min(c.parameters for c in near)
    return min((c for c in near if c.parameters == fewest), key=lambda c: c.losses.mean())


def within_one_error(losses: np.ndarray, best: np.ndarray) -> bool:
    """Whether the mean of losses (blocks,) is within one standard error of that of the best ones (blocks,)."""
    difference = losses - best
    return bool(difference.mean() <= standard_error(difference))


def one_per_families(models: Sequence[ComparedModel]) -> list[ComparedModel]:
    """The simplest sufficient form of every family or pair of families, the least loss first."""
    groups: dict[frozenset[str], list[ComparedModel]] = {}
    for model in models:
        groups.setdefault(model.families, []).append(model)
    return sorted((simplest_sufficient(group) for group in groups.values()), key=lambda c: c.losses.mean())


def without_undetermined_additions(
    models: Sequence[ComparedModel], errors: Mapping[int, np.ndarray], criteria: Criteria
) -> list[ComparedModel]:
    """The models without those whose additional magnitudes, beside another one of them, are all within
    `Criteria.value_errors` standard errors of zero.

    errors holds the standard errors (parameters,) by the id of a model.
    """
    return [m for m in models if not any(_adds_nothing(m, other, errors[id(m)], criteria) for other in models)]


def _adds_nothing(model: ComparedModel, other: ComparedModel, errors: np.ndarray, criteria: Criteria) -> bool:
    """Whether a model contains another one of the same families, and adds only undetermined magnitudes to it."""
    found, known = model.fit, set(other.fit.model.own)
    if model.families != other.families or not known < set(found.model.own):
        return False
    names = {found.model.names[i] for effect in model.effects for i in magnitudes_of(found, effect)} - known
    values = {n: value for n, value in parameters_of(found, errors).items() if n in names}
    return bool(values) and len(undetermined(values, criteria.value_errors)) == len(values)
