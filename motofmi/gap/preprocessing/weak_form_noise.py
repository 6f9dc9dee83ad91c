"""The disturbance of a run in weak form: what a rich model with constant gains leaves of every equation.

    x' = sum_j c_j feature_j + w

The features are the states and their products with the speed and its square, the inputs, and powers, moduli and signs of deflections
and rates, all at the same time: no features of the past, and no gains that depend on frequency. A rate's derivative is a
filter of the rate, and under closed-loop control of an input, so that such features would explain any disturbance. A
model that is as good as this one has a reduced chi-square of 1.

Source: Ljung, System Identification, 2nd ed. (1999), ch. 13.4, on direct identification in closed loop.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from identification.gap.data.flexible import Density, features_of
from identification.gap.data.weak_form import WeakRun, whitener

ROUNDS = 3
BANDS = 16  # of the disturbance's spectrum


def disturbance(run: WeakRun, states: Sequence[np.ndarray], inputs: Sequence[np.ndarray], speed: np.ndarray, deflections: Sequence[np.ndarray],
                rates: Sequence[np.ndarray]) -> list[Density]:  # fmt: skip
    """The density of each equation's disturbance, from channels (n,) over the whole recording."""
    signals = [*states, *(speed**power * x for x in states for power in (1, 2)), *inputs]
    taken = [x[run.places].ravel() for x in signals]
    angles, speeds = ([x[run.places].ravel() for x in each] for each in (deflections, rates))
    weak = run.tested(np.stack([x.reshape(run.places.shape) for x in features_of(angles, speeds, taken)]))
    return [_left(run, weak, measured) for measured in run.measured]


def _left(run: WeakRun, features: np.ndarray, measured: np.ndarray) -> Density:
    """The density of what features (j, blocks, k) leave of one equation (blocks, k)."""
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
        left = (target - matrix @ gains).reshape(len(measured), -1) @ np.linalg.pinv(whiten)
        free = 1 - (rank / len(measured) + run.nuisance.shape[1]) / len(frequency)
        power = np.array([np.mean(left[:, a:b] ** 2) for a, b in pairwise(edges)])
        density = Density(middle, power / free)
    return density
