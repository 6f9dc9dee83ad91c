"""The loop over the steps in Python: for every kind of subsystem."""

import numpy as np

from fmus.cosimulation.coupling_protocol import RunningCoupling
from fmus.cosimulation.network import Network


class InterpretedMaster:
    """Runs a prepared coupling. `done` counts the steps of the last call that were made."""

    chunk = 200  # steps between two checks by the caller

    def __init__(self, network: Network, state: RunningCoupling):
        self.network, self.state, self.done = network, state, 0
        self.outputs = np.zeros(len(network.outputs))

    def begin(self, outputs: np.ndarray) -> None:
        """Set the outputs (ny,) at the start of the run."""
        self.outputs = outputs.copy()

    def steps(self, external: np.ndarray, outputs: np.ndarray, end_inputs: np.ndarray) -> None:
        """n steps with external inputs (n + 1, nu); writes outputs (n, ny) and the inputs at the end
        of each step (n, nu)."""
        self.done = 0
        for k in range(len(external) - 1):
            self.network.external[:] = external[k : k + 2]
            self.outputs = self.state.advance(self.outputs)
            outputs[k], end_inputs[k] = self.outputs, self.state.end_inputs
            self.done = k + 1
