"""Spectrum and analytic signal, compared with those of SciPy."""

import numpy as np
import pytest
from scipy.signal import hilbert
from scipy.signal import periodogram as scipy_periodogram

from motofmi.recordings.spectra import analytic_signal, periodogram

SIZES = (2, 3, 64, 1001)
ROUNDING = 1e-12  # over the largest value: both are discrete Fourier transforms of at most 1001 numbers


@pytest.mark.parametrize("size", SIZES)
def test_the_periodogram_is_that_of_scipy(size):
    signal = np.random.default_rng(size).normal(5.0, 2.0, size)
    frequency, power = periodogram(signal, 250.0)
    expected_frequency, expected = scipy_periodogram(signal, 250.0)
    np.testing.assert_allclose(frequency, expected_frequency, rtol=1e-14)
    np.testing.assert_allclose(power, expected, rtol=0, atol=ROUNDING * expected.max())


@pytest.mark.parametrize("size", SIZES)
def test_the_analytic_signal_is_that_of_scipy(size):
    signal = np.random.default_rng(size).normal(5.0, 2.0, size)
    np.testing.assert_allclose(analytic_signal(signal), hilbert(signal), rtol=0, atol=ROUNDING * np.abs(signal).max())
