"""A ball on a beam under position control, by the Runge-Kutta formula of order four from equations of its own.

    x'' = g_e sin(a(t - d)) - f tanh(x' / v_s),   a = 1.2 (r(t) - x) - 0.7 x' + a_d(t)

a is the commanded angle of the beam, held between samples, d the delay of its servo, f dry friction per mass. The
reference r is a sum of sines, a_d a small sine.
"""

import numpy as np

from motofmi.recordings.recording import Recording

GAIN = 7.0  # m/s2, 5/7 of gravity for a solid ball
SUBSTEPS = 5  # of a sample
SLIDING = 1e-3  # m/s
NOISE = 5e-4  # m


def beam_run(name: str, seconds: float, rate: float, seed: int, delay: float = 0.0, friction: float = 0.0) -> Recording:
    """The angle of the beam [rad] and the position of the ball [m]."""
    random = np.random.default_rng(seed)
    frequencies, phases = random.uniform(0.05, 0.6, 5), random.uniform(0, 2 * np.pi, 5)
    count, step = int(seconds * rate), 1 / (rate * SUBSTEPS)
    lag = round(delay * rate * SUBSTEPS)
    commands, state = [0.0] * (lag + 1), np.zeros(2)
    angle, position = np.zeros(count), np.zeros(count)

    def rates(x: np.ndarray, beam: float) -> np.ndarray:
        return np.array([x[1], GAIN * np.sin(beam) - friction * np.tanh(x[1] / SLIDING)])

    for k in range(count):
        t = k / rate
        reference = 0.1 * np.sum(np.sin(2 * np.pi * frequencies * t + phases))
        angle[k] = np.clip(1.2 * (reference - state[0]) - 0.7 * state[1], -0.3, 0.3)
        angle[k] += 0.05 * np.sin(2 * np.pi * 1.3 * t + phases[0])
        position[k] = state[0]
        for _ in range(SUBSTEPS):
            commands.append(angle[k])
            beam = commands[-1 - lag]
            k1 = rates(state, beam)
            k2 = rates(state + step / 2 * k1, beam)
            k3 = rates(state + step / 2 * k2, beam)
            k4 = rates(state + step * k3, beam)
            state = state + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    position += NOISE * random.standard_normal(count)
    return Recording(
        name, np.arange(count) / rate, {"beam": angle, "position": position}, {"beam": "rad", "position": "m"}
    )
