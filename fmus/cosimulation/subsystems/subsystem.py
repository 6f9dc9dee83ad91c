"""The interface of a subsystem that a coupling steps, and the linear subsystem, stepped exactly.

    x' = A x + B u,   y = C x + D u,   u(s) = sum_k c_k s^k
    x(H) = e^(AH) x + sum_k Gamma_k c_k,   Gamma_k = k! H phi_(k+1)(AH) B

All Gamma are blocks of one matrix exponential (Van Loan, IEEE Trans. Autom. Control 23, 1978). The state may
have columns (nx, n): then n linear simulations are run at once. Started from the columns of the identity they give the
transition matrix of the coupling.
"""

from math import factorial
from typing import Any, Protocol

import numpy as np
from scipy.linalg import expm

from fmus.cosimulation.polynomials import COEFFICIENTS, ORDER
from fmus.linear_analysis.linearisation import StateSpace


class Subsystem(Protocol):
    """One simulator: an FMU, or a model of one. Every array may carry more axes behind the ones named here."""

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    feedthrough: np.ndarray  # (ny, nu): which output depends on which input at the same time
    input_order: int  # of the polynomials that a step takes as inputs
    output_order: int  # how many derivatives of the outputs can be read
    can_restore: bool

    @property
    def present_inputs(self) -> np.ndarray:
        """The inputs (nu,) as they were set last."""

    def unit_of(self, variable: str) -> str:
        """The unit of measure of a variable."""

    def exchange(self, inputs: np.ndarray) -> np.ndarray:
        """Set the present inputs (nu,), read the outputs (ny,)."""

    def output_slope(self, slopes: np.ndarray) -> np.ndarray:
        """The k-th derivative of the outputs (ny,) with the inputs' derivatives (k, nu), orders 1 to k."""

    def state_rates(self) -> np.ndarray:
        """The derivatives of the states (nx,) at present."""

    def step(self, coefficients: np.ndarray, step: float) -> None:
        """Step with the inputs as polynomials, coefficients (4, nu) in powers of s = time / step."""

    def save(self, into: Any = None) -> Any:
        """The state for `restore`; `into` is an earlier saved state that may be overwritten."""

    def restore(self, saved: Any) -> None:
        """Restore a saved state."""

    def linearised(self) -> StateSpace:
        """The subsystem linearised at its present state."""


class LinearSubsystem:
    """A linear model as a subsystem, by default with all capabilities."""

    def __init__(
        self, space: StateSpace, input_order: int = ORDER, output_order: int = ORDER, can_restore: bool = True
    ):
        self.space = space
        self.inputs, self.outputs = space.inputs, space.outputs
        self.feedthrough = space.D != 0
        self.input_order, self.output_order, self.can_restore = input_order, output_order, can_restore
        self.state = np.zeros(len(space.states))
        self._present = np.zeros(len(space.inputs))
        self._matrices: dict[float, tuple[np.ndarray, list[np.ndarray]]] = {}

    def multiplied(self, number: int) -> "LinearSubsystem":
        """As many equal subsystems as one, whose outputs are the sums."""
        s = self.space
        space = StateSpace(s.A, s.B, number * s.C, number * s.D, s.states, s.inputs, s.outputs)
        return LinearSubsystem(space, self.input_order, self.output_order, self.can_restore)

    @property
    def present_inputs(self) -> np.ndarray:
        return self._present

    def unit_of(self, variable: str) -> str:
        return ""

    def exchange(self, inputs: np.ndarray) -> np.ndarray:
        self._present = inputs
        return self.space.C @ self.state + self.space.D @ inputs

    def output_slope(self, slopes: np.ndarray) -> np.ndarray:
        rates = self.state_rates()
        for slope in slopes[:-1]:
            rates = self.space.A @ rates + self.space.B @ slope
        return self.space.C @ rates + self.space.D @ slopes[-1]

    def state_rates(self) -> np.ndarray:
        return self.space.A @ self.state + self.space.B @ self._present

    def step(self, coefficients: np.ndarray, step: float) -> None:
        if step not in self._matrices:
            self._matrices[step] = self._exact_step(step)
        transition, gammas = self._matrices[step]
        self.state = transition @ self.state + sum(g @ c for g, c in zip(gammas, coefficients, strict=True))

    def _exact_step(self, step: float) -> tuple[np.ndarray, list[np.ndarray]]:
        nx, nu = self.space.B.shape
        blocks = np.zeros((nx + COEFFICIENTS * nu, nx + COEFFICIENTS * nu))
        blocks[:nx, :nx], blocks[:nx, nx : nx + nu] = self.space.A * step, self.space.B * step
        blocks[nx:-nu, nx + nu :] = np.eye(ORDER * nu)
        first = expm(blocks)[:nx] if nx else np.zeros((0, len(blocks)))
        return first[:, :nx], [factorial(k) * first[:, nx + k * nu : nx + (k + 1) * nu] for k in range(COEFFICIENTS)]

    def save(self, into: np.ndarray | None = None) -> np.ndarray:
        return self.state

    def restore(self, saved: np.ndarray) -> None:
        self.state = saved

    def linearised(self) -> StateSpace:
        return self.space
