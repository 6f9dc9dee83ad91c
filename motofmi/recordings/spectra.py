"""Spectra and analytic signal of a uniformly sampled signal, by the discrete Fourier transform.

The functions of scipy.signal give the same values, but importing it takes 0.5 s in every search.

Source: Oppenheim, Schafer, Discrete-Time Signal Processing, 3rd ed. (2010), ch. 10.3, 10.5 and 12.
"""

import numpy as np


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


def short_time_spectra(values: np.ndarray, rate: float, length: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies (m,), in the unit of the sampling rate, the middle times (parts,) of overlapping parts of `length`
    samples, and the spectrum (m, parts) of each part of a signal (n,), n >= length, about its mean in a Hann window.

    The squared modulus, and the product of one spectrum and the conjugate of another, are one-sided densities; means
    over parts are those of Welch's method.
    """
    step = length - length // 2
    parts = np.lib.stride_tricks.sliding_window_view(values, length)[::step]
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(length) / length)
    found = np.fft.rfft((parts - parts.mean(axis=1, keepdims=True)) * window) / np.sqrt(rate * np.sum(window**2))
    found[:, 1 : (length + 1) // 2] *= np.sqrt(2)
    return np.fft.rfftfreq(length, 1 / rate), (np.arange(len(parts)) * step + length / 2) / rate, found.T
