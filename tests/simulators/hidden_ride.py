"""Rides of a motorcycle with something hidden, made apart from the package: Kane's equations, Runge and Kutta's rule at 1 ms.

The rider holds the handlebar loosely: he steers against the roll, later by his reaction time, and shakes it at several
frequencies. Wind and road push with a torque in roll, a side force and a torque about the steer axis, in part white, in
part slow. Only some channels are logged, with white noise.
"""

import numpy as np
from numba import njit

from tests.simulators.hidden_vehicle import equations

RATE, FINE = 100, 10  # samples per second, steps per sample
SPEEDS = 25  # of a grid between which equations are interpolated
REACTION = 0.15  # s
KICKS, KICK = 3.0, 0.2  # s between pulses, and of one
SENSORS = {"steer_angle": ("delta", "deg", 5e-4), "roll_rate": ("p", "deg/s", 4e-3), "yaw_rate": ("r", "deg/s", 4e-3),
           "roll_angle": ("phi", "deg", 3e-3), "steer_rate": ("s", "deg/s", 4e-3)}  # state, unit in the file, noise in SI  # fmt: skip
WHITE = (4.0, 4.0, 0.05)  # deviation per sample of roll torque [N.m], side force [N], steer torque [N.m]
SLOW, CORNER = (8.0, 15.0, 0.3), 0.5  # deviation, and the corner [Hz] of what is slow


@njit(cache=True)
def _run(inverses, slopes_over_speed, where, forces, push, shake, friction, gain, torque_gain, place, reaction, late):
    count, nx = len(shake), len(forces)
    states, torques = np.zeros((count, nx)), np.zeros(count + 1)
    x = np.zeros(nx)
    roll_rate, roll, steer_rate = place
    h = 1.0 / (RATE * FINE)
    for k in range(count):
        states[k] = x
        node = int(where[k])
        share = where[k] - node
        inverse = (1 - share) * inverses[node] + share * inverses[node + 1]
        slopes = (1 - share) * slopes_over_speed[node] + share * slopes_over_speed[node + 1]
        past = max(min(k + 1, count - 1) - reaction, 0)
        torques[k + 1] = shake[min(k + 1, count - 1)] - gain[0] * states[past, roll] - gain[1] * states[past, roll_rate]
        for step in range(FINE):
            given = torques[max(k - late, 0)] if late else torques[k] + (torques[k + 1] - torques[k]) * step / FINE
            k1 = np.zeros(nx)
            total = np.zeros(nx)
            for stage in range(4):
                y = x + k1 * (0.0 if stage == 0 else (h if stage == 3 else h / 2))
                f = slopes @ y + forces @ push[k]
                f[steer_rate] += torque_gain * given - friction * np.tanh(y[steer_rate] / 0.02)
                k1 = inverse @ f
                total += k1 * (1.0 if stage in (0, 3) else 2.0)
            x = x + h / 6 * total
    return states, torques[:count]


def ride(rng: np.random.Generator, p: dict, speed: float | tuple[float, float], hidden: dict | None = None, duration: float = 100.0, pushed: float = 1.0,
         shaken: float = 1.0, gain: tuple[float, float] = (0.0, 0.0), kicked: float = 0.0) -> dict[str, np.ndarray]:  # fmt: skip
    """Time, speed, torque and every state by the name of Kane's equations, without noise, at 100 Hz.

    speed [m/s] is one, or those between which it swings. hidden may hold friction [N.m], the delay of the motor in
    samples and its gain; pushed and shaken scale the disturbances and the shaking, kicked [N.m] is the size of pulses
    of the torque.
    """
    hidden = dict(hidden or {})
    friction, late, torque_gain = hidden.pop("friction", 0.0), hidden.pop("motor", 0), hidden.pop("motor_gain", 1.0)
    n = int(duration * RATE)
    time = np.arange(n) / RATE
    slowest, fastest = (speed, speed) if np.isscalar(speed) else speed
    speeds = (slowest + fastest) / 2 + (fastest - slowest) / 2 * np.sin(2 * np.pi * time / duration + rng.uniform(0, 6))
    grid = np.linspace(slowest, fastest, SPEEDS)
    every = [equations(p, v, hidden) for v in grid]
    names = every[0][2]
    where = np.clip((speeds - slowest) / max(fastest - slowest, 1e-9) * (SPEEDS - 1), 0, SPEEDS - 1 - 1e-9)
    decay = np.exp(-2 * np.pi * CORNER / RATE)
    slow = rng.standard_normal((n, 3)) * SLOW * np.sqrt(1 - decay**2)
    for k in range(1, n):
        slow[k] += decay * slow[k - 1]
    push = pushed * (slow + rng.standard_normal((n, 3)) * WHITE)
    frequency = np.concatenate([rng.uniform(0.4, 4.0, 6), rng.uniform(4.0, 9.0, 3)])
    shake = shaken * sum(1.5 * np.sin(2 * np.pi * f * time + rng.uniform(0, 6)) for f in frequency)
    if kicked:
        shake = shake + kicked * np.convolve(
            rng.random(n) < 1 / (KICKS * RATE), np.hanning(int(KICK * RATE)), "same"
        ) * np.sign(np.sin(time))
    forces = np.zeros((len(names), 3))
    for column, name in enumerate(("p", "v", "s")):
        forces[names.index(name), column] = 1.0
    place = tuple(names.index(name) for name in ("p", "phi", "s"))
    inverses, slopes = np.array([np.linalg.inv(m) for m, _, _ in every]), np.array([s for _, s, _ in every])
    states, torques = _run(
        inverses, slopes, where, forces, push, shake, friction, gain, torque_gain, place, int(REACTION * RATE), late
    )
    return {"time": time, "speed": speeds, "steer_torque": torques, **dict(zip(names, states.T, strict=True))}


def write_ride(path, ridden: dict[str, np.ndarray], rng: np.random.Generator, sensors: tuple[str, ...] = ("steer_angle", "roll_rate", "yaw_rate"),
               torque: bool = True, late: dict[str, int] | None = None, noise_factor: float = 1.0) -> str:  # fmt: skip
    """Path of the recording as a CSV file with these channels.

    `late`: delay of a channel in samples. `noise_factor`: factor of the standard deviations of the noise.
    """
    header, columns = (
        ["time [s]", "speed [m/s]"],
        [ridden["time"], ridden["speed"] + 0.02 * rng.standard_normal(len(ridden["time"]))],
    )
    if torque:
        header, columns = [*header, "steer_torque [N.m]"], [*columns, ridden["steer_torque"]]
    for name in sensors:
        state, unit, noise = SENSORS[name]
        values = np.roll(ridden[state], (late or {}).get(name, 0)) + noise_factor * noise * rng.standard_normal(
            len(ridden["time"])
        )
        header, columns = [*header, f"{name} [{unit}]"], [*columns, np.degrees(values)]
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=",".join(header), comments="", fmt="%.9g")
    return str(path)
