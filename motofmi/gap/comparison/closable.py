r"""The closable misfit, and the share of it that a model closes on data that were not used for estimation.

    share = (S_base - S_model) / (S_base - S_flexible)

S are mean squares of residuals on validation runs. S_flexible is the mean square after a flexible nonparametric
regression (see `preprocessing.flexible_noise_model`): no model of the library is expected to have less. The interval
comes from resampled blocks (bootstrap).
"""

from dataclasses import dataclass

import numpy as np

from motofmi.gap.comparison.compared_model import ComparedModel
from motofmi.gap.comparison.confidence_set import resampled_blocks
from motofmi.gap.estimation.fit_result import Fit

INTERVAL = (2.5, 97.5)  # percentiles of the resampled means: the 95 % interval


@dataclass(frozen=True)
class Share:
    """A share [1] with the ends of its 95 % interval."""

    share: float
    low: float
    high: float


def closed_share(before: np.ndarray, after: np.ndarray, flexible: float) -> Share:
    """The share of the closable misfit that a model closes.

    before and after (blocks,) are the mean squares of the base and of the model on the same blocks, flexible is the
    mean square after the flexible regression, in the same unit. A single block does not determine an interval: it is
    then that of all possible shares.
    """
    if len(before) < 2:
        return Share(float(_share(before.mean(), after.mean(), flexible)), -1.0, 1.0)
    chosen = resampled_blocks(len(before))
    low, high = np.percentile(_share(before[chosen].mean(axis=1), after[chosen].mean(axis=1), flexible), INTERVAL)
    return Share(float(_share(before.mean(), after.mean(), flexible)), float(low), float(high))


def closes_as_much(
    model: ComparedModel, other: ComparedModel, base: ComparedModel, flexible: float, share: float
) -> bool:
    """Whether a model closes the share of the closable misfit that another one closes, or at most `share` [1] less, with
    no more parameters."""
    closable = max(float(base.out_of_sample.mean()) - flexible, 1e-300)
    more = float(model.out_of_sample.mean() - other.out_of_sample.mean())
    return model.parameters <= other.parameters and more < share * closable


def log_gain_low(base: ComparedModel, model: ComparedModel) -> float:
    """The lower end of the 95 % interval of the mean gain in logarithmic loss on data that were not used."""
    return low_of_mean(np.log(base.out_of_sample + base.floor) - np.log(model.out_of_sample + model.floor))


def low_of_mean(values: np.ndarray) -> float:
    """The lower end of the 95 % interval of the mean of values (blocks,)."""
    return float(np.percentile(values[resampled_blocks(len(values))].mean(axis=1), INTERVAL[0]))


def _share(before: np.ndarray, after: np.ndarray, flexible: float) -> np.ndarray:
    """The share of the closable misfit for mean squares before and after (any shape), within -1 to 1."""
    closable = np.maximum(before - flexible, 1e-12 * before)
    return np.clip((before - after) / closable, -1.0, 1.0)


def flexible_mean_square(found: Fit, scale: np.ndarray) -> float:
    """The mean square [1] after a flexible regression on a fit's runs, each output over its scale (outputs,)."""
    power, samples = np.zeros(len(scale)), 0
    for run, with_noise in zip(found.runs, found.runs_with_remaining_noise(), strict=True):
        owner = run.reduction.output_of
        power += [float(np.sum(with_noise.deviation[owner == output] ** 2)) for output in range(len(scale))]
        samples += sum(last - first for first, last, _ in run.reduction.spans)
    return float(np.mean(power / samples / scale**2))
