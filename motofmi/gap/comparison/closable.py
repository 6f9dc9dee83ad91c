r"""The closable misfit, and the share of it that a model closes on data that were not used for estimation.

    share = (S_base - S_model) / (S_base - S_flexible)

S are mean squares on validation runs. S_flexible is what a flexible nonparametric regression leaves (see
`preprocessing.flexible_noise_model`): no model of the library is expected to leave less. The interval is that of resampled
blocks.
"""

from dataclasses import dataclass

import numpy as np

from motofmi.gap.comparison.confidence_set import RESAMPLES, SEED
from motofmi.gap.comparison.contender import Contender
from motofmi.gap.estimation.fit_result import Fit

INTERVAL = (2.5, 97.5)  # per cent


@dataclass(frozen=True)
class Share:
    """A share with its 95 % interval."""

    share: float
    low: float
    high: float


def explained_share(base: Contender, model: Contender, flexible: float) -> Share:
    """The share of the closable misfit that a model closes; flexible is the mean square of the regression."""
    before, after = base.held_out, model.held_out
    chosen = np.random.default_rng(SEED).integers(0, len(before), (RESAMPLES, len(before)))
    shares = share_of_closable(before[chosen].mean(axis=1), after[chosen].mean(axis=1), flexible)
    low, high = np.percentile(shares, INTERVAL)
    return Share(float(share_of_closable(before.mean(), after.mean(), flexible)), float(low), float(high))


def log_gain_low(base: Contender, model: Contender) -> float:
    """The lower end of the 95 % interval of the mean gain in logarithmic loss on data that were not used."""
    gain = np.log(base.held_out + base.floor) - np.log(model.held_out + model.floor)
    chosen = np.random.default_rng(SEED).integers(0, len(gain), (RESAMPLES, len(gain)))
    return float(np.percentile(gain[chosen].mean(axis=1), INTERVAL[0]))


def share_of_closable(before: np.ndarray, after: np.ndarray, flexible: float) -> np.ndarray:
    """The share of the closable misfit for mean squares before and after (any shape), within -1 to 1."""
    closable = np.maximum(before - flexible, 1e-12 * before)
    return np.clip((before - after) / closable, -1.0, 1.0)


def flexible_mean_square(found: Fit, scale: np.ndarray) -> float:
    """The mean square that a flexible regression leaves of a fit's runs, in units of the outputs' scale (outputs,)."""
    power, samples = np.zeros(len(scale)), 0
    for index, run in enumerate(found.runs):
        quiet = found.model.with_remaining_noise(run, found.of_run(index))
        owners = np.array([column.degree for column in run.reduction.columns])
        power += [float(np.sum(quiet.deviation[owners == output] ** 2)) for output in range(len(scale))]
        samples += sum(last - first for first, last, _ in run.reduction.spans)
    return float(np.mean(power / samples / scale**2))
