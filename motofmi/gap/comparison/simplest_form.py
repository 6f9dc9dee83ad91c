"""The form of an effect: the simplest one whose mean loss is within one standard error of the best form's.

Source: the one-standard-error rule of Breiman, Friedman, Olshen, Stone, Classification and Regression Trees (1984),
section 3.4.3, with the standard error of the paired differences of losses.
"""

from collections.abc import Sequence

import numpy as np

from motofmi.gap.comparison.block_losses import standard_error
from motofmi.gap.comparison.compared_model import ComparedModel


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
