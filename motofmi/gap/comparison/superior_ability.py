r"""The test for superior predictive ability: whether any of many models is better than a benchmark.

    d_kb = l_0b - l_kb,   T = max_k max(d_k / s(d_k), 0),   d_k = mean_b d_kb

The one that seems best of many models gains by chance, the more so the more there are. The distribution of T under the
null hypothesis that no model is better than the benchmark comes from resampled blocks, with the gains of all models at
once. Models that are clearly worse than the benchmark, d_k / s(d_k) < -sqrt(2 log log n) for n blocks, keep their mean
and therefore do not count (Hansen's consistent p-value).

    p = superior_ability(losses[0], losses[1:])

Source: Hansen, J. Business Economic Statist. 23 (2005) 365-380, after White, Econometrica 68 (2000) 1097-1126.
"""

import numpy as np

from motofmi.gap.comparison.confidence_set import resampled_blocks


def superior_ability(benchmark: np.ndarray, losses: np.ndarray) -> float:
    """The p-value of the null hypothesis that no model is better than the benchmark.

    benchmark (blocks,) and losses (models, blocks) are losses on the same blocks, which were not used for estimation.
    """
    gains = benchmark - losses
    blocks = gains.shape[1]
    means, resampled = (
        gains.mean(axis=1),
        gains[:, resampled_blocks(blocks)].mean(axis=2),
    )  # (models,), (models, resamples)
    deviation = np.std(resampled, axis=1)
    deviation[deviation == 0] = np.inf
    worse = means / deviation < -np.sqrt(2 * np.log(np.log(max(blocks, 3))))
    centred = resampled - np.where(worse, 0.0, means)[:, None]
    statistic = max(float(np.max(means / deviation)), 0.0)
    largest = np.maximum(np.max(centred / deviation[:, None], axis=0), 0.0)
    return float(np.mean(largest >= statistic))
