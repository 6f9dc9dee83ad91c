"""A coupling as the co-simulation uses it: what it is called, what it costs, and its state during a run."""

from typing import NamedTuple, Protocol

import numpy as np

from fmus.cosimulation.network import Network


class Cost(NamedTuple):
    """What a step needs; couplings are compared entry by entry, the cheapest first.

    One pass is cheaper than repeated passes, no linearisation of the subsystems than one, few output derivatives than
    many, a low order than a high one, and stepping all subsystems at once than reading one before the next one steps.
    """

    repeated: bool = False
    linearised: bool = False
    output_derivatives: int = 0
    order: int = 1
    sequential: bool = False


class RunningCoupling(Protocol):
    """A coupling on one network with one step [s]. end_inputs (nu, ...): all inputs at the end of the last step."""

    step: float
    end_inputs: np.ndarray
    memory: np.ndarray

    def start(self, outputs: np.ndarray) -> None:
        """Prepare the first step, from where `outputs` (ny,) were read."""

    def advance(self, outputs: np.ndarray) -> np.ndarray:
        """Step all subsystems from where `outputs` (ny, ...) were read; the outputs after the step."""


class Coupling(Protocol):
    """A coupling by name: one line of summary, the order of its error in the step, and its source."""

    @property
    def name(self) -> str: ...

    @property
    def summary(self) -> str: ...

    @property
    def order(self) -> int: ...

    @property
    def source(self) -> str: ...

    @property
    def cost(self) -> Cost: ...

    def missing_capability(self, network: Network) -> str:
        """The capability that subsystems lack for this coupling; empty when they lack none."""

    def prepare(self, network: Network, step: float) -> RunningCoupling:
        """The coupling on a network with a step [s]."""
