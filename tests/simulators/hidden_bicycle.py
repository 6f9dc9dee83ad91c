"""Runs of an unstable bicycle under closed-loop control with something hidden, made apart from the package.

The benchmark bicycle's printed matrices (Meijaard et al. 2007), integrated by Runge and Kutta's rule at 1 ms with
torque disturbances held over 10 ms; a controller steers into the fall, and somebody shakes the handlebar.
"""

import numpy as np
from numba import njit

M = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = np.array([[0, 76.59734589573222], [0, 2.65431523794604]])
C1 = np.array([[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
RATE, FINE = 100, 10  # samples per second, steps per sample
COLUMNS = (
    "speed [m/s]",
    "roll_angle [rad]",
    "roll_rate [rad/s]",
    "steer_angle [rad]",
    "steer_rate [rad/s]",
    "steer_torque [N.m]",
)


def bicycle(rng: np.random.Generator, share: float) -> tuple[np.ndarray, ...]:
    """(M, K0, K2, C1) of one that differs from the published by that share, entry by entry; M and K0 stay symmetric."""
    changed = []
    for matrix in (M, K0, K2, C1):
        factor = 1 + share * rng.standard_normal((2, 2))
        factor[1, 0] = factor[0, 1]
        changed.append(matrix * factor)
    return tuple(changed)


@njit(cache=True)
def _run(M, K0, K2, C1, speed, push, shake, friction, damping, delay, gain):
    count = len(speed)
    inverse = np.linalg.inv(M)
    states, torques = np.zeros((count, 4)), np.zeros(count)
    x = np.zeros(4)
    h = 1.0 / (RATE * FINE)
    for k in range(count):
        v = speed[k]
        torques[k] = shake[k] + gain * x[2]  # steers into the fall
        states[k] = x
        given = torques[max(k - delay, 0)]
        for _ in range(FINE):
            slopes = np.zeros((4, 4))
            y = x.copy()
            for stage in range(4):
                q, s = y[:2], y[2:]
                force = -v * (C1 @ s) - 9.81 * (K0 @ q) - v * v * (K2 @ q)
                force[0] += push[k, 0]
                force[1] += push[k, 1] + given - friction * np.tanh(s[1] / 0.02) - damping * s[1]
                slopes[stage, :2] = s
                slopes[stage, 2:] = inverse @ force
                y = x + h * (0.5 if stage < 2 else 1.0) * slopes[stage]
            x = x + h / 6 * (slopes[0] + 2 * slopes[1] + 2 * slopes[2] + slopes[3])
    return states, torques


def ride(rng: np.random.Generator, model: tuple[np.ndarray, ...], duration: float = 120.0, friction: float = 0.0, damping: float = 0.0,
         delay: int = 0, pushed: float = 1.0, shaken: float = 1.0, speeds: tuple[float, float] = (4.0, 5.6)) -> np.ndarray:  # fmt: skip
    """A recording (n, 7): time and COLUMNS; the delay of the motor is in samples. pushed and shaken scale
    the disturbances and the shaking."""
    n = int(duration * RATE)
    time = np.arange(n) / RATE
    speed = np.mean(speeds) + np.ptp(speeds) / 2 * np.sin(2 * np.pi * time / duration * 2 + rng.uniform(0, 6))
    push = pushed * rng.standard_normal((n, 2)) * [4.0, 0.1]
    shake = shaken * sum(np.sin(2 * np.pi * f * time + rng.uniform(0, 6)) for f in (0.7, 1.1, 1.6, 2.3, 3.1))
    states, torques = _run(*(np.ascontiguousarray(m) for m in model), speed, push, shake, friction, damping, delay, 8.0)
    noise = rng.standard_normal((n, 4)) * [2e-4, 2e-4, 2e-3, 2e-3]
    roll, steer, roll_rate, steer_rate = (states + noise).T
    return np.column_stack([time, speed, roll, roll_rate, steer, steer_rate, torques])


def write_ride(path, ridden: np.ndarray) -> str:
    """The recording as a CSV file; its path."""
    np.savetxt(path, ridden, delimiter=",", header=",".join(("time [s]", *COLUMNS)), comments="", fmt="%.8g")
    return str(path)


def write_matrices(path) -> str:
    """The bicycle as it is known, as a .toml of matrices; its path."""
    zero, one = np.zeros((2, 2)), np.eye(2)
    B = np.linalg.inv(M)
    matrices = {"A0": np.block([[zero, one], [-B @ (9.81 * K0), zero]]), "A1": np.block([[zero, zero], [zero, -B @ C1]]),
                "A2": np.block([[zero, zero], [-B @ K2, zero]]), "B": np.vstack([zero, B])}  # fmt: skip
    path.write_text("\n".join(f"{n} = {m.tolist()}" for n, m in matrices.items()) + "\n", encoding="utf-8")
    return str(path)
