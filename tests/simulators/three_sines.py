"""A motion along three sines, exact with its derivatives."""

import numpy as np

SINES = ((0.05, 0.31), (0.02, 0.83), (0.01, 1.7))  # amplitude in m, frequency in Hz


def three_sines(generator: np.random.Generator, time: np.ndarray) -> np.ndarray:
    """Displacement [m], rate [m/s] and acceleration [m/s2] (3, n) at times [s] (n,), with random phases."""
    motion = np.zeros((3, len(time)))
    for amplitude, frequency in SINES:
        w, phase = 2 * np.pi * frequency, generator.uniform(0, 2 * np.pi)
        sine, cosine = np.sin(w * time + phase), np.cos(w * time + phase)
        motion += amplitude * np.array([sine, w * cosine, -(w**2) * sine])
    return motion
