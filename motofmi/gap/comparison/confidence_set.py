r"""The model confidence set: the models that are not distinguishable from the best one, by losses of the same blocks.

    d_ij = mean_b (l_ib - l_jb),   t_ij = d_ij / s(d_ij),   T_R = max_ij |t_ij|

Starting from all models, equal performance is tested with the range statistic T_R, whose distribution under the null
hypothesis comes from resampled blocks; while it is rejected, the model with the largest max_j t_ij is eliminated. The
set that remains contains the best model with probability 1 - level. No model has to be complete, and no noise has to
be known.

    set_, p = confidence_set(losses)     # losses (models, blocks)

Source: Hansen, Lunde, Nason, Econometrica 79 (2011) 453-497.
"""

import numpy as np

RESAMPLES = 1000
SEED = 1  # of the resampled blocks: the same data give the same answer


def confidence_set(losses: np.ndarray, level: float = 0.05) -> tuple[list[int], np.ndarray]:
    """The indices of the models in the set, in the order of their mean loss, and the p-value of every model.

    losses (models, blocks) are those of all models on the same blocks; level is the probability with which the best
    model is eliminated. A model is in the set if its p-value (models,) is at least the level.
    """
    models, blocks = losses.shape
    chosen = np.random.default_rng(SEED).integers(0, blocks, (RESAMPLES, blocks))
    means, resampled = losses.mean(axis=1), losses[:, chosen].mean(axis=2)  # (models,), (models, resamples)
    difference = means[:, None] - means[None, :]
    centred = (resampled[:, None] - resampled[None, :]) - difference[:, :, None]
    deviation = np.sqrt(np.mean(centred**2, axis=2))
    deviation[deviation == 0] = np.inf
    t, resampled_t = difference / deviation, np.abs(centred) / deviation[:, :, None]
    left, values, so_far = list(range(models)), np.ones(models), 0.0
    while len(left) > 1:
        here = np.ix_(left, left)
        statistic = np.max(np.abs(t[here]))
        largest = resampled_t[here].max(axis=(0, 1))
        so_far = max(so_far, float(np.mean(largest >= statistic)))
        worst = left[int(np.argmax(t[here].max(axis=1)))]
        values[worst] = so_far
        left.remove(worst)
    inside = [int(i) for i in np.argsort(means) if values[i] >= level]
    return inside, values
