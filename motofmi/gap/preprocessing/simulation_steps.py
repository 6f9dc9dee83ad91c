"""The number of simulation steps per sample that the motion of a recording needs.

The formula of Hermite and Simpson advances the phase of an oscillation with the angular frequency w, in a step h, by
w h + (w h)^5 / 720. The error of a motion with the spectrum P, over its rms, is after a cycle

    sqrt(sum of e^2 P / sum of P),   e(f) = min(1, 2 pi (2 pi f h)^4 / 720)

High frequencies with little power, such as coloured noise of a rate sensor, add little to it.

Source: Hairer, Wanner, Solving Ordinary Differential Equations II, 2nd ed. (1996), ch. IV.3, for the Pade
approximation (2, 2) of the exponential function.
"""

import numpy as np

from motofmi.gap.preprocessing.motion_spectrum import power_shares

ERROR = 1e-4  # of a simulation after a cycle, over the rms of the motion; a third of the least noise of a run
STEPS_PER_CYCLE = 8  # simulation steps per cycle of half the sampling rate, which are enough for any spectrum
MOST_STEPS = 40_000  # simulation steps of one run


def simulation_steps(measured: np.ndarray, rate: float) -> int:
    """The fewest simulation steps per sample for the motion of outputs (n, outputs) at a sampling rate [Hz]."""
    most = max(min(MOST_STEPS // len(measured), STEPS_PER_CYCLE // 2), 1)
    spectra = [power_shares(values, rate) for values in measured.T]
    enough = (
        steps for steps in range(1, most)
        if all(phase_error(frequency, shares, 1 / (rate * steps)) < ERROR for frequency, shares in spectra)
    )  # fmt: skip
    return next(enough, most)


def phase_error(frequency: np.ndarray, shares: np.ndarray, step: float) -> float:
    """The error after a cycle, over the rms of a motion with shares of its power (m,) at frequencies (m,) [Hz], of a
    simulation with a step [s]."""
    error = np.minimum(2 * np.pi * (2 * np.pi * frequency * step) ** 4 / 720, 1.0)
    return float(np.sqrt(np.sum(error**2 * shares)))
