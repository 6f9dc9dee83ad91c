"""The signals before the start, extrapolated backwards with the linearised coupled subsystems.

    y(tau) = y_0 + C tau phi_1(A tau) x'_0,   tau = -H, -2 H, ...

with A, C of the coupled subsystems linearised at the start. A coupling that extrapolates from former steps thereby
keeps its order from the first step on. Where a subsystem does not provide its state rates, the signals are constant.
"""

import numpy as np
from scipy.linalg import expm

from fmus.cosimulation.network import Network


def past_signals(network: Network, outputs: np.ndarray, step: float, reach: int) -> np.ndarray:
    """The signals (reach, signals) one, two ... steps before `outputs` (ny,) were read."""
    now = outputs[network.signal_outputs]
    if reach == 0:
        return np.zeros((0, len(now)))
    space = network.linearised()
    network.settle(outputs)
    rates = np.concatenate([subsystem.state_rates() for subsystem, _, _ in network.parts])
    if len(rates) != len(space.states):
        return np.tile(now, (reach, 1))
    nx = len(rates)
    blocks = np.zeros((nx + 1, nx + 1))
    blocks[:nx, :nx], blocks[:nx, nx] = space.A, rates
    state_response = np.array([expm(-k * step * blocks)[:nx, nx] for k in range(1, reach + 1)])
    return now + state_response @ space.C[network.signal_outputs].T
