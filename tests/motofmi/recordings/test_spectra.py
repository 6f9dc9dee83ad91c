"""Spectra and analytic signal, compared with those of SciPy."""

import numpy as np
import pytest
from scipy.signal import csd, hilbert, welch
from scipy.signal import periodogram as scipy_periodogram
from scipy.signal import spectrogram as scipy_spectrogram

from motofmi.recordings.spectra import analytic_signal, cross_spectrum, periodogram, spectrogram

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


@pytest.mark.parametrize("length", [16, 63, 250])
def test_the_spectra_of_windows_are_those_of_scipy(length):
    generator = np.random.default_rng(length)
    first, second = generator.normal(5.0, 2.0, (2, 250))
    second += first
    for found, expected in (
        (spectrogram(first, 250.0, length),
         scipy_spectrogram(first, 250.0, window="hann", nperseg=length, noverlap=length // 2)),
        (cross_spectrum(first, second, 250.0, length), csd(first, second, 250.0, nperseg=length)),
        (cross_spectrum(first, first, 250.0, length), welch(first, 250.0, nperseg=length)),
    ):  # fmt: skip
        for each, known in zip(found, expected, strict=True):
            np.testing.assert_allclose(each, known, rtol=0, atol=ROUNDING * np.abs(known).max())
