"""The loop over the steps in Python: for every kind of unit."""

import numpy as np

from fmus.coupling import Network
from fmus.coupling.interface_jacobian import Prediction
from fmus.coupling.scheme import Run


class InterpretedMaster:
    """Runs a prepared coupling. `done` counts the steps of the last call that were made."""

    chunk = 200  # steps between two looks from outside

    def __init__(self, network: Network, running: Run | Prediction):
        self.network, self.running, self.done = network, running, 0
        self.outputs = np.zeros(len(network.outputs))

    def begin(self, outputs: np.ndarray) -> None:
        """Where the run begins: the outputs (ny,) as they were read."""
        self.outputs = outputs.copy()

    def steps(self, external: np.ndarray, outputs: np.ndarray, told: np.ndarray) -> None:
        """n steps with inputs from outside (n + 1, nu); writes outputs (n, ny) and what the inputs were told (n, nu)."""
        self.done = 0
        for k in range(len(external) - 1):
            self.network.external[:] = external[k : k + 2]
            self.outputs = self.running.advance(self.outputs)
            outputs[k], told[k] = self.outputs, self.running.told
            self.done = k + 1
