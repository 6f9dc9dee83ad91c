"""What the signals would have been before the start, had the coupled units always been running.

    y(tau) = y_0 + C tau phi_1(A tau) x'_0,   tau = -H, -2 H, ...

with A, C of the coupled units linearised at the start. So a coupling that continues signals from former steps
keeps its order from the first step on. Where a unit does not show its rates the signals are taken as constant.
"""

import numpy as np
from scipy.linalg import expm

from fmus.coupling.network import Network


def past_signals(network: Network, outputs: np.ndarray, step: float, reach: int) -> np.ndarray:
    """The signals (reach, signals) one, two ... steps before `outputs` (ny,) were read."""
    now = outputs[network.where]
    if reach == 0:
        return np.zeros((0, len(now)))
    space = network.linearised()
    network.settle(outputs)
    rates = np.concatenate([unit.state_rates() for unit, _, _ in network.part])
    if len(rates) != len(space.states):
        return np.tile(now, (reach, 1))
    nx = len(rates)
    blocks = np.zeros((nx + 1, nx + 1))
    blocks[:nx, :nx], blocks[:nx, nx] = space.A, rates
    moved = np.array([expm(-k * step * blocks)[:nx, nx] for k in range(1, reach + 1)])
    return now + moved @ space.C[network.where].T
