"""Spectra and analytic signal, compared with those of SciPy."""

import numpy as np
import pytest
from scipy.signal import csd, hilbert, spectrogram, welch
from scipy.signal import periodogram as scipy_periodogram

from motofmi.recordings.spectra import analytic_signal, periodogram, short_time_spectra

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


@pytest.mark.parametrize("length", [16, 17, 250])
def test_short_time_spectra_are_those_of_scipy(length):
    rng = np.random.default_rng(length)
    x, y = rng.normal(5.0, 2.0, (2, 1001))
    (frequency, middle, of_x), (_, _, of_y) = (short_time_spectra(each, 250.0, length) for each in (x, y))
    options = {"fs": 250.0, "window": "hann", "nperseg": length, "noverlap": length // 2}
    expected_frequency, expected_middle, power = spectrogram(x, **options)
    np.testing.assert_allclose(frequency, expected_frequency, rtol=1e-14)
    np.testing.assert_allclose(middle, expected_middle, rtol=1e-14)
    of_parts = np.abs(of_x) ** 2
    np.testing.assert_allclose(of_parts, power, rtol=0, atol=ROUNDING * power.max())
    np.testing.assert_allclose(of_parts.mean(axis=1), welch(x, **options)[1], rtol=0, atol=ROUNDING * power.max())
    cross = np.mean(of_x.conj() * of_y, axis=1)
    np.testing.assert_allclose(cross, csd(x, y, **options)[1], rtol=0, atol=ROUNDING * power.max())
