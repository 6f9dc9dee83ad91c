"""Spectrum and analytic signal of a uniformly sampled signal, by the discrete Fourier transform.

The functions of scipy.signal give the same values, but importing it takes 0.5 s at the start of every search.

Source: Oppenheim, Schafer, Discrete-Time Signal Processing, 3rd ed. (2010), ch. 10.5 and 12.
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
