"""Linear models of FMUs from their outputs alone, where an output is computed at the steps only."""

import numpy as np
import pytest

from fmus.cosimulation.subsystems.era import era


class Sampled:
    """The outputs of x' = -3 x + u at a step's end, and of a damper that holds its torque -5 u until then."""

    inputs, outputs = ("rate",), ("position", "torque")
    values, begin = (), 0.0

    def __init__(self, lag: bool):
        self.lag, self.present_inputs = lag, np.zeros(1)
        self.outputs = ("position", "torque") if lag else ("torque",)
        self.restart()

    def twin(self):
        return Sampled(self.lag)

    def close(self):
        """There is nothing to end."""

    def restart(self, *_):
        self.x = self.torque = 0.0

    def step(self, held, step):
        u = held[0, 0]
        self.x = np.exp(-3 * step) * self.x + (1 - np.exp(-3 * step)) / 3 * u
        self.torque = -5 * u

    def exchange(self, inputs):
        return np.array([self.x, self.torque] if self.lag else [self.torque])


@pytest.mark.parametrize("lag", [True, False])
def test_an_output_that_is_held_until_the_next_step_is_a_static_gain(lag):
    """It has no continuous mode: the logarithm of its transition would be infinite, with a warning."""
    found = era(Sampled(lag))
    # Singular values below 1e-8 of the largest are no states.
    assert np.linalg.eigvals(found.A) == pytest.approx([-3.0] * lag, rel=1e-6)
    assert found.D[-1] == pytest.approx([-5.0], rel=1e-6)
    if lag:
        gain = found.D - found.C @ np.linalg.solve(found.A, found.B)
        assert gain == pytest.approx(np.array([[1 / 3], [-5.0]]), rel=1e-6)
