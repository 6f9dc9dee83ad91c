"""The model confidence set on losses whose distribution is known."""

import numpy as np
import pytest
from scipy.stats import norm

from motofmi.gap.comparison.confidence_set import confidence_set


@pytest.mark.slow
def test_equal_models_stay_in_the_set():
    # The set holds the best model with probability 0.95 or more; with 200 draws a share below 0.9 has probability
    # 0.003.
    kept = 0
    for seed in range(200):
        losses = np.random.default_rng(seed).normal(size=(4, 40))
        kept += 0 in confidence_set(losses)[0]
    assert kept / 200 >= 0.9


def test_a_model_that_loses_on_every_block_is_eliminated():
    common = np.random.default_rng(1).normal(size=30)
    losses = np.array([common, common + 0.5 + 0.1 * np.random.default_rng(2).normal(size=30)])
    inside, p = confidence_set(losses)
    assert inside == [0] and p[0] == 1.0 and p[1] < 0.001


def test_blocks_that_all_models_find_hard_do_not_matter():
    # Differences of losses are compared: what all models share cancels.
    random = np.random.default_rng(3)
    easy = random.normal(size=(3, 24)) * 0.1 + np.array([0.0, 0.3, 0.05])[:, None]
    hard = easy + 10 * random.normal(size=24)
    assert confidence_set(easy)[0] == confidence_set(hard)[0]


def test_two_models_give_the_p_value_of_the_paired_test():
    # For two models T_R is |t| of the paired difference, normally distributed in resamples of 60 blocks; resampling of
    # 1,000 and the normal approximation differ by at most about 0.03.

    difference = np.random.default_rng(4).normal(0.15, 1.0, 60)
    p = confidence_set(np.array([np.zeros(60), difference]))[1]
    t = difference.mean() / (difference.std() / np.sqrt(60))
    assert abs(min(p) - 2 * norm.sf(abs(t))) < 0.03


def test_the_same_losses_give_the_same_set():
    losses = np.random.default_rng(5).normal(size=(5, 20))
    assert np.array_equal(confidence_set(losses)[1], confidence_set(losses)[1])
