"""The test for superior predictive ability on gains whose distribution is known."""

import numpy as np
import pytest
from scipy.stats import norm

from motofmi.gap.comparison.superior_ability import superior_ability

BLOCKS = 60


def p_value(gains):
    """Of models (models, blocks) that gain that much on a benchmark whose losses do not matter."""
    benchmark = np.random.default_rng(9).normal(size=gains.shape[1])
    return superior_ability(benchmark, benchmark - gains)


def test_one_model_gives_the_p_value_of_the_one_sided_paired_test():
    # Normal in resamples of 60 blocks; 1,000 resamples and the normal approximation differ by at most about 0.03.
    gains = np.random.default_rng(4).normal(0.15, 1.0, (1, BLOCKS))
    t = gains.mean() / (gains.std() / np.sqrt(BLOCKS))
    assert abs(p_value(gains) - norm.sf(t)) < 0.03


def test_of_many_independent_models_the_largest_gain_counts_for_as_many():
    # P(max of k standard normals > t) = 1 - Phi(t)^k; the means of the models are far from the limit of clearly worse.
    gains = np.random.default_rng(1).normal(size=(20, BLOCKS))
    t = np.max(gains.mean(axis=1) / (gains.std(axis=1) / np.sqrt(BLOCKS)))
    assert abs(p_value(gains) - (1 - norm.cdf(t) ** 20)) < 0.06  # 0.016 by resampling, the rest of the normal limit


@pytest.mark.slow
def test_it_rejects_as_seldom_as_its_level_says():
    # 100 draws of five equal models: the 99.9 % quantile of the binomial with 0.05 is 13.
    rejected = sum(p_value(np.random.default_rng(seed).normal(size=(5, BLOCKS))) < 0.05 for seed in range(100))
    assert rejected <= 13


def test_models_that_are_clearly_worse_do_not_count():
    # Hansen's consistent p-value is that of the others alone; White's would grow with every poor model.
    good = np.random.default_rng(2).normal(0.25, 1.0, (2, BLOCKS))
    poor = np.random.default_rng(3).normal(-5.0, 1.0, (10, BLOCKS))
    assert p_value(np.vstack([good, poor])) == p_value(good)


def test_a_model_that_is_no_better_than_the_benchmark_has_p_value_one():
    assert p_value(np.full((1, BLOCKS), -1.0)) == 1.0
    assert p_value(np.zeros((3, BLOCKS))) == 1.0
