"""The disturbance of a run in weak form, estimated as the residual of a flexible model of every equation.

    x' = sum_j c_j feature_j + w

The features are the states and their products with the speed and its square, the inputs, and powers, moduli and signs
of deflections and rates, all at the same time. Past features and gains that depend on frequency are excluded: the
derivative of a rate is a filter of the rate, and under closed-loop control of an input, so they would explain any
disturbance. A model with a residual of the same size has a reduced chi-square of 1.

Source: Ljung, System Identification, 2nd ed. (1999), ch. 13.4, on direct identification in closed loop.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from motofmi.gap.preprocessing.flexible_noise_model import Density, features_of
from motofmi.gap.preprocessing.weak_form import WeakFormRun, whitener

ROUNDS = 3  # rounds of whitening and regression
BANDS = 16  # bands of the disturbance's spectrum


def disturbance(
    run: WeakFormRun,
    states: Sequence[np.ndarray],
    inputs: Sequence[np.ndarray],
    speed: np.ndarray,
    deflections: Sequence[np.ndarray],
    rates: Sequence[np.ndarray],
) -> list[Density]:
    """The disturbance density of each equation [(rad/s2)^2 per sample], from channels (n,) over the whole recording."""
    signals = [*states, *(speed**power * x for x in states for power in (1, 2)), *inputs]
    taken = [x[run.places].ravel() for x in signals]
    angles, speeds = ([x[run.places].ravel() for x in each] for each in (deflections, rates))
    weak = run.tested(np.stack([x.reshape(run.places.shape) for x in features_of(angles, speeds, taken)]))
    return [_residual_density(run, weak, measured) for measured in run.measured]


def _residual_density(run: WeakFormRun, features: np.ndarray, measured: np.ndarray) -> Density:
    """The density of the residual of one equation (blocks, k) after regression on features (j, blocks, k)."""
    frequency = run.frequency
    edges = np.unique(np.linspace(0, len(frequency), BANDS + 1).astype(int))
    middle = np.array([frequency[a:b].mean() for a, b in pairwise(edges)])
    density = Density(middle, np.ones(len(middle)))
    for _ in range(ROUNDS):
        whiten = whitener(density(frequency), run.nuisance)
        matrix = (features @ whiten).reshape(len(features), -1).T
        matrix = matrix / (np.linalg.norm(matrix, axis=0) + 1e-300)
        target = (measured @ whiten).ravel()
        gains, _, rank, _ = np.linalg.lstsq(matrix, target, rcond=1e-8)
        residual = (target - matrix @ gains).reshape(len(measured), -1) @ np.linalg.pinv(whiten)
        free = 1 - (rank / len(measured) + run.nuisance.shape[1]) / len(frequency)
        power = np.array([np.mean(residual[:, a:b] ** 2) for a, b in pairwise(edges)])
        density = Density(middle, power / free)
    return density
