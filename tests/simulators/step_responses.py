"""Step responses of a slide with dry friction, in closed form: they end with its travel, and are short."""

import numpy as np

from motofmi.recordings.recording import Recording

MASS, DAMPING, FRICTION, TRAVEL, RATE = 0.5, 16.0, 1.3, 0.2, 200.0  # kg, N.s/m, N, m, Hz
QUANTUM = 1.5e-5  # m, of the encoder


def step_response(force: float, from_rest: bool = True, rate: float = RATE) -> Recording:
    """The displacement [m] under a constant force [N], from rest or from the final rate on, at a sampling rate [Hz].

    m x'' = F - c x' - f sign(F):   x = v (t - tau (1 - exp(-t / tau))),   v = (F - f sign(F)) / c,   tau = m / c
    """
    final, lag = (force - FRICTION * np.sign(force)) / DAMPING, MASS / DAMPING
    time = np.arange(0.0, TRAVEL / abs(final) + lag, 1 / rate)
    exact = final * (time - from_rest * lag * (1 - np.exp(-time / lag)))
    columns = {"force": np.full(len(time), force), "displacement": QUANTUM * np.round(exact / QUANTUM)}
    return Recording(f"step_{force:g}_N", time, columns, {"force": "N", "displacement": "m"})
