"""The noise and the highest frequency of quantised signals, from the steps between their levels."""

import numpy as np
import pytest

from motofmi.gap.preprocessing.input_interpolation import highest_frequency
from motofmi.recordings.resampling import quantisation_step, sensor_noise, white_noise

RATE, STEP = 200.0, 0.04  # Hz, rad
TIME = np.arange(4000) / RATE
SLOW = 0.2 * np.sin(2 * np.pi * 0.4 * TIME) + 0.1 * np.sin(2 * np.pi * 0.93 * TIME + 1)  # rad
LEVELS = STEP * np.round(SLOW / STEP)


def test_a_level_that_lasts_has_the_noise_of_its_step():
    assert white_noise(LEVELS) == 0
    assert quantisation_step(LEVELS) == pytest.approx(STEP, rel=1e-9)
    # The error is uniform over a step only where the levels are passed at a constant rate: within 10 % with 15 levels.
    assert sensor_noise(LEVELS) == pytest.approx(np.std(LEVELS - SLOW), rel=0.1)


def test_a_few_interpolated_samples_leave_the_step():
    bridged = LEVELS.copy()
    bridged[[700, 701, 2500]] += STEP * np.array([0.3, 0.7, 0.5])
    assert quantisation_step(bridged) == pytest.approx(STEP, rel=1e-9)


@pytest.mark.parametrize("noise", [0.0, 1e-4, STEP])
def test_continuous_values_have_no_step(noise):
    y = SLOW + noise * np.random.default_rng(0).standard_normal(len(SLOW))
    assert quantisation_step(y) == 0
    assert sensor_noise(y) == white_noise(y)
    assert quantisation_step(np.maximum(y, 0)) == 0  # a stop, at which one value recurs
    assert quantisation_step(5 * TIME) == 0  # a constant rate: equal steps, but no level recurs


def test_steps_between_levels_are_no_motion():
    # Levels are passed at most 0.2 * 2 pi * 0.4 / STEP + 0.1 * 2 pi * 0.93 / STEP = 27 times a second; above that rate
    # the error is below the level of white noise with its variance.
    assert highest_frequency(SLOW, RATE) < 2
    assert highest_frequency(LEVELS, RATE) < 27
