"""A joint with linear damping and a spring under a smooth torque, whose response scipy simulates."""

import numpy as np
from scipy.signal import StateSpace

INERTIA, DAMPING, STIFFNESS = 0.05, 0.1, 2.0  # kg.m2, N.m.s/rad, N.m/rad
JOINT = StateSpace([[0, 1], [-STIFFNESS / INERTIA, -DAMPING / INERTIA]], [[0], [1 / INERTIA]], [[1, 0]], [[0]])
NOISE = 1e-3  # of the standard deviation of the angle


def smooth_torque(time: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """25 sines of random phases from 0.1 Hz to 2.5 Hz, in N.m."""
    rates, phases = 2 * np.pi * np.linspace(0.1, 2.5, 25), random.uniform(0, 2 * np.pi, 25)
    return np.cos(np.outer(time, rates) + phases).sum(axis=1) / 5


def with_noise(angle: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """An angle (n,) as a sensor with normal noise gives it."""
    return angle + NOISE * np.std(angle) * random.standard_normal(len(angle))
