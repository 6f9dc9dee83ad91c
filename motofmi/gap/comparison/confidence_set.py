r"""The model confidence set: the models that are not distinguishable from the best one, by losses on the same blocks.

    d_ij = mean_b (l_ib - l_jb),   t_ij = d_ij / s(d_ij),   T_R = max_ij |t_ij|

Starting from all models, equal performance is tested with the range statistic T_R, whose distribution under the null
hypothesis comes from resampled blocks. As long as it is rejected, the model with the largest max_j t_ij is eliminated.
The set that remains contains the best model with probability 1 - level. No model has to be complete, and the noise
need not be known.

    models, p = confidence_set(losses)     # losses (models, blocks)

Source: Hansen, Lunde, Nason, Econometrica 79 (2011) 453-497.
"""

import numpy as np

RESAMPLES = 1000  # bootstrap samples: the standard error of a p-value of 0.05 is then 0.007
SEED = 1  # of the random numbers of the bootstrap: the same data give the same result


def resampled_blocks(blocks: int) -> np.ndarray:
    """The indices (RESAMPLES, blocks) of blocks drawn with replacement, the same in every call."""
    return np.random.default_rng(SEED).integers(0, blocks, (RESAMPLES, blocks))


def confidence_set(losses: np.ndarray, level: float = 0.05) -> tuple[list[int], np.ndarray]:
    """The indices of the models in the set, in the order of their mean loss, and the p-value (models,) of every model.

    losses (models, blocks) are those of all models on the same blocks; level is the probability with which the best
    model is eliminated. A model is in the set if its p-value is at least the level.
    """
    models, blocks = losses.shape
    chosen = resampled_blocks(blocks)
    means, resampled = losses.mean(axis=1), losses[:, chosen].mean(axis=2)  # (models,), (models, resamples)
    difference = means[:, None] - means[None, :]
    centred = (resampled[:, None] - resampled[None, :]) - difference[:, :, None]
    deviation = np.sqrt(np.mean(centred**2, axis=2))
    deviation[deviation == 0] = np.inf
    t, resampled_t = difference / deviation, np.abs(centred) / deviation[:, :, None]
    remaining, p_values, largest_p = list(range(models)), np.ones(models), 0.0
    while len(remaining) > 1:
        pairs = np.ix_(remaining, remaining)
        statistic = np.max(np.abs(t[pairs]))
        largest = resampled_t[pairs].max(axis=(0, 1))
        largest_p = max(largest_p, float(np.mean(largest >= statistic)))
        worst = remaining[int(np.argmax(t[pairs].max(axis=1)))]
        p_values[worst] = largest_p
        remaining.remove(worst)
    inside = [int(i) for i in np.argsort(means) if p_values[i] >= level]
    return inside, p_values
