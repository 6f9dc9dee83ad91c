"""Spectra and analytic signal of uniformly sampled signals, by the discrete Fourier transform.

The functions of scipy.signal give the same values, but importing it takes 0.5 s in every search.

Source: Oppenheim, Schafer, Discrete-Time Signal Processing, 3rd ed. (2010), ch. 10.5 and 12; Welch, IEEE Trans. Audio
Electroacoust. 15 (1967) 70-73.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view


def periodogram(values: np.ndarray, rate: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (m,), in the unit of the sampling rate, and the one-sided power density (m,) of a signal (n,) about
    its mean, with m = n // 2 + 1."""
    n = len(values)
    power = np.abs(np.fft.rfft(values - values.mean())) ** 2 / (rate * n)
    power[1 : (n + 1) // 2] *= 2
    return np.fft.rfftfreq(n, 1 / rate), power


def analytic_signal(values: np.ndarray) -> np.ndarray:
    """The complex signal (n,) whose real part is a signal (n,) and which has no negative frequencies."""
    n = len(values)
    spectrum = np.fft.fft(values)
    spectrum[1 : (n + 1) // 2] *= 2
    spectrum[n // 2 + 1 :] = 0
    return np.fft.ifft(spectrum)


def spectrogram(values: np.ndarray, rate: float, length: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies (m,), times (windows,) of the windows' middles from the first sample, and one-sided power densities
    (m, windows) of a signal (n,) in windows of `length` samples."""
    frequency, transforms = _of_windows(values, rate, length)
    begins = np.arange(len(transforms)) * (length - length // 2)
    return frequency, (begins + length / 2) / rate, (np.abs(transforms) ** 2).T


def cross_spectrum(first: np.ndarray, second: np.ndarray, rate: float, length: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (m,) and the one-sided cross power density (m,) of two signals (n,): the mean of conj(X) Y over
    windows of `length` samples. With itself it is the power density of a signal by Welch's method."""
    (frequency, x), (_, y) = (_of_windows(values, rate, length) for values in (first, second))
    return frequency, np.mean(np.conj(x) * y, axis=0)


def _of_windows(values: np.ndarray, rate: float, length: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (m,) and the transforms (windows, m) of a signal in Hann windows that overlap by half, each about its
    mean; their squares are one-sided power densities."""
    parts = sliding_window_view(values, length)[:: length - length // 2]
    window = np.sin(np.pi * np.arange(length) / length) ** 2
    transforms = np.fft.rfft((parts - parts.mean(axis=1, keepdims=True)) * window) / np.sqrt(rate * np.sum(window**2))
    transforms[:, 1 : (length + 1) // 2] *= np.sqrt(2)
    return np.fft.rfftfreq(length, 1 / rate), transforms
