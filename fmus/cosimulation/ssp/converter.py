"""A connection that changes its value, y = factor u + offset, as a subsystem between the output and the input."""

import numpy as np

from fmus.cosimulation.polynomials import COEFFICIENTS, ORDER
from fmus.cosimulation.ssp.units import Affine
from fmus.linear_analysis.linearisation import StateSpace


class Converter:
    """The subsystem `name` with the input `given` and the output `converted`; it has no state."""

    inputs: tuple[str, ...] = ("given",)
    outputs: tuple[str, ...] = ("converted",)
    feedthrough = np.ones((1, 1), bool)
    input_order, output_order, can_restore = ORDER, ORDER, True

    def __init__(self, change: Affine, units: tuple[str, str]):
        self.change, self._units = change, dict(zip(self.inputs + self.outputs, units, strict=True))
        self._present = np.zeros(1)

    @property
    def present_inputs(self) -> np.ndarray:
        return self._present

    def unit_of(self, variable: str) -> str:
        return self._units[variable]

    def exchange(self, inputs: np.ndarray) -> np.ndarray:
        self._present = inputs
        return self.change.factor * inputs + self.change.offset

    def output_slope(self, slopes: np.ndarray) -> np.ndarray:
        return self.change.factor * slopes[-1]

    def state_rates(self) -> np.ndarray:
        return np.zeros(0)

    def step(self, coefficients: np.ndarray, step: float) -> None:
        assert len(coefficients) == COEFFICIENTS

    def save(self, into: None = None) -> None:
        """There is no state to save."""

    def restore(self, saved: None) -> None:
        """There is no state to restore."""

    def linearised(self) -> StateSpace:
        gain = np.array([[self.change.factor]])
        return StateSpace(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), gain, (), self.inputs, self.outputs)
