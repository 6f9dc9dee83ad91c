"""Implicit in one pass: the signals are predicted from the linearised subsystems, and every FMU steps once.

The coupled subsystems are linear over a step, x' = x'_0 + A (x - x_0) + B e' tau, so with their outputs and
state rates at its start

    y(tau) = y_0 + C (tau phi_1(A tau) x'_0 + tau^2 phi_2(A tau) B e') + D e' tau

    int_0^1 (1-s)^j (y(s H) - y_0) ds = j! (C (H phi_(j+2)(A H) x'_0 + H^2 phi_(j+3)(A H) B e') + H / (j+2)! D e')

where e are the external inputs. Each FMU gets the polynomial nearest to that in the mean square, of the order
that it accepts: for linear subsystems the error of a step is of order H^(2k+3) with inputs of order k, far less than
that of any interpolation of the same order. x'_0 and y_0 are read from the FMUs in every step, so the linearisation
need not be exact; it is renewed when its prediction of the end of a step has missed.

The interface Jacobian in co-simulation: Sicklinger et al., Int. J. Numer. Meth. Engng 98 (2014) 418-444; the
exponential step with the present rates: Hochbruck, Ostermann, Acta Numerica 19 (2010) 209-286, sect. 2.4. The
projection is this project's own.
"""

from math import factorial

import numpy as np
from numpy.polynomial import Legendre, Polynomial
from scipy.linalg import expm

from fmus.cosimulation.coupling_protocol import Cost
from fmus.cosimulation.network import Network
from fmus.cosimulation.polynomials import COEFFICIENTS, ORDER, from_moments

MISSED = 1e-2  # of the change over the step
LOOK = 8  # steps from one comparison with the prediction to the next: it costs a sixth of a small FMU's step

# Legendre's polynomials P_i(s), shifted to [0, 1], in powers of 1 - s.
LEGENDRE = np.array(
    [
        (-1) ** i * np.pad(Legendre.basis(i, [0, 1]).convert(kind=Polynomial).coef, (0, ORDER - i))
        for i in range(COEFFICIENTS)
    ]
)


class InterfaceJacobian:
    """The coupling as the module's docstring describes it."""

    name = "interface_jacobian"
    summary = "implicit in one pass, from the FMUs' linearisation; no saved states"
    order = 4
    cost = Cost(linearised=True, order=4)
    source = "Sicklinger et al., Int. J. Numer. Meth. Engng 98 (2014) 418-444"

    def missing_capability(self, network: Network) -> str:
        """The capability that subsystems lack for this coupling; empty when they lack none."""
        hidden = [
            name
            for name, subsystem in network.subsystems.items()
            if len(subsystem.state_rates()) != len(subsystem.linearised().states)
        ]
        return f"{' and '.join(hidden)} does not show the rates of its states" if hidden else ""

    def prepare(self, network: Network, step: float) -> "InterfaceJacobianState":
        return InterfaceJacobianState(network, step)


class InterfaceJacobianState:
    """The coupling on one network with one step. end_inputs as in `fmus.cosimulation.scheme.CouplingState`.

    The data of a step are the signals, the states' rates and the slopes of the external inputs; `expected`
    (drives, data) gives the predicted change over the step of the sums that drive inputs (`Network.drives`).
    """

    def __init__(self, network: Network, step: float):
        self.network, self.step = network, step
        self.end_inputs = np.zeros(len(network.inputs))
        self.memory = np.zeros((0, len(network.signals)))
        self.count = 0
        self.renew()

    def start(self, outputs: np.ndarray) -> None:
        """This coupling has no memory of former steps."""

    def renew(self) -> None:
        """Linearise the subsystems at their present states and compute the matrices of the step."""
        network, H = self.network, self.step
        space = network.linearised()
        drives, signals = network.drives, len(network.signals)
        direct = drives @ space.D[network.signal_outputs]
        phi = phi_functions(drives @ space.C[network.signal_outputs], space.A * H, COEFFICIENTS + 2)

        def change(j: int) -> np.ndarray:
            """(drives, nx + ne): the integral of (1-s)^j / j! times the change of the drives, per
            unit of x'_0 and e'."""
            return np.hstack([H * phi[j + 1], H**2 * phi[j + 2] @ space.B + H * direct / factorial(j + 2)])

        moments = np.tensordot(LEGENDRE, np.stack([factorial(j) * change(j) for j in range(COEFFICIENTS)]), 1)
        present = np.stack([drives, *np.zeros((COEFFICIENTS - 1, *drives.shape))])
        moments = np.concatenate([present, moments], axis=2)
        self.expected = np.hstack([np.zeros((len(drives), signals)), change(-1)])
        self.free = [network.inputs.index(name) for name in space.inputs]
        self.matrices = [
            np.tensordot(from_moments(subsystem.input_order), moments[:, network.drive_of[u]], 1)
            .reshape(COEFFICIENTS * len(subsystem.inputs), moments.shape[-1])
            for subsystem, u, _ in network.parts
        ]  # fmt: skip

    def advance(self, outputs: np.ndarray) -> np.ndarray:
        """Step all subsystems from where `outputs` (ny, ...) were read; the outputs after the step."""
        network, columns = self.network, outputs.shape[1:]
        if self.end_inputs.shape[1:] != columns:
            self.end_inputs = np.zeros((len(network.inputs), *columns))
        network.settle(outputs)
        slopes = (network.external[1] - network.external[0])[self.free] / self.step
        now = outputs[network.signal_outputs]
        rates = [subsystem.state_rates() for subsystem, _, _ in network.parts]
        data = np.concatenate(
            [now, *rates, np.broadcast_to(slopes.reshape(-1, *[1] * len(columns)), (len(slopes), *columns))]
        )
        for index, (subsystem, u, _) in enumerate(network.parts):
            coefficients = (self.matrices[index] @ data).reshape(COEFFICIENTS, len(subsystem.inputs), *columns)
            network.add_external(coefficients, index)
            self.end_inputs[u] = coefficients.sum(axis=0)
            subsystem.step(coefficients, self.step)
        outputs = network.read(outputs, end=1)
        self.count += 1
        if self.count % LOOK == 1 and self._has_missed(data, outputs[network.signal_outputs] - now):
            self.renew()
        return outputs

    def _has_missed(self, data: np.ndarray, change: np.ndarray) -> bool:
        """Whether the sums that drive inputs have changed otherwise than predicted; change (signals, ...) is
        that of the signals."""
        expected = self.expected @ data
        return bool(
            np.abs(self.network.drives @ change - expected).max(initial=0.0)
            > MISSED * np.abs(expected).max(initial=0.0)
        )


def phi_functions(rows: np.ndarray, matrix: np.ndarray, highest: int) -> np.ndarray:
    """rows phi_1, ..., rows phi_highest (highest, m, n) of a matrix (n, n) and rows (m, n).

    All are blocks of one exponential (Sidje 1998, theorem 1, transposed), the last block row first.
    """
    (m, n), scale = rows.shape, max(np.abs(rows).max(initial=0.0), 1e-300)
    blocks = np.zeros((highest * m + n,) * 2)
    blocks[: (highest - 1) * m, m : highest * m] = np.eye((highest - 1) * m)
    blocks[(highest - 1) * m : highest * m, highest * m :] = rows / scale
    blocks[highest * m :, highest * m :] = matrix
    return (
        scale * expm(blocks)[: highest * m, highest * m :].reshape(highest, m, n)[::-1]
        if n
        else np.zeros((highest, m, 0))
    )


COUPLING = InterfaceJacobian()
