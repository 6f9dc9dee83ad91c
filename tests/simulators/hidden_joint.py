"""A recording of a joint that hides something."""

import numpy as np

from motofmi.recordings.recording import Recording
from tests.simulators.hidden_mechanisms import excitation, sensed, simulate

JOINT = {"J": 0.08, "k": 14.0, "c": 0.12, "sliding": 1e-3}


def joint_run(hidden, kind="multisine", seed=0, duration=10.0, rate=100.0, noise=2e-3, name="run", start=(0.0, 0.0)):
    """About 30 periods of 2.1 Hz, with white noise [rad] in the angle."""
    rng = np.random.default_rng(seed)
    time = np.arange(0, duration, 1 / rate)
    drive = excitation(kind, rng, duration, 4.0, 2.0)
    motion, torque = simulate(JOINT, hidden, drive, time, start)
    columns = {"torque": torque, "angle": sensed(hidden, motion[:, 0]) + noise * rng.standard_normal(len(time))}
    return Recording(name, time, columns, {"torque": "N.m", "angle": "rad"})
