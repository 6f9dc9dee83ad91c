"""Couplings by interpolation: a polynomial for each signal over a step, and the order in which subsystems step.

A scheme lists the knots through which each signal's polynomial passes: `before` its source has stepped, and `after` (in
a sequential coupling for the subsystems that step later than the source; in an iterated one for all subsystems from the
second pass on). An angle whose rate is also a signal can have knots of its own, with that rate as a derivative. The
polynomials of a subsystem's inputs are linear in the data: one matrix, computed once for a step size.
"""

from dataclasses import dataclass

import numpy as np

from fmus.cosimulation.coupling_protocol import Cost
from fmus.cosimulation.history import past_signals
from fmus.cosimulation.network import Network
from fmus.cosimulation.polynomials import COEFFICIENTS, Knot, Knots, nearest, through
from fmus.support.errors import StepTooLongError

PASSES = 200
CONVERGED = 1e-10  # of the largest signal; rounding errors of differences in a torque are smaller


@dataclass(frozen=True)
class Continuation:
    """The knots of a signal, and, where they differ, those of an angle whose rate is a signal and of such a rate.

    `rate` None means the derivative of the angle's polynomial.
    """

    signal: Knots
    angle: Knots = ()
    rate: Knots | None = ()

    def knots(self) -> set[Knot]:
        return {*self.signal, *(self.angle or ()), *(self.rate or ())}


@dataclass(frozen=True)
class Scheme:
    """A coupling by its knots; `order` is the order in the step of the error after a given time."""

    name: str
    summary: str
    order: int
    source: str
    before: Continuation
    after: Continuation | None = None
    sequential: bool = False
    iterated: bool = False

    def missing_capability(self, network: Network) -> str:
        """The capability that subsystems lack for this coupling; empty when they lack none."""
        if self.iterated:
            names = [n for n, subsystem in network.subsystems.items() if not subsystem.can_restore]
            if names:
                return f"{' and '.join(names)} cannot save and restore the FMU state"
        wanted = self.slopes_needed
        names = [n for n, subsystem in network.subsystems.items() if subsystem.output_order < wanted]
        if names:
            return f"{' and '.join(names)} cannot give derivatives of the outputs up to order {wanted}"
        return ""

    @property
    def cost(self) -> Cost:
        """What a step needs, for the order of the couplings."""
        return Cost(self.iterated, False, self.slopes_needed, self.order, self.sequential)

    @property
    def slopes_needed(self) -> int:
        """The highest derivative of the outputs that is read."""
        parts = [self.before, *([self.after] if self.after else [])]
        return max((d for part in parts for _, d in _read(part)), default=0)

    @property
    def reach(self) -> int:
        """The number of former steps whose signals are used."""
        parts = [self.before, *([self.after] if self.after else [])]
        return max(-place for part in parts for place, _ in part.knots())

    def prepare(self, network: Network, step: float) -> "CouplingState":
        return CouplingState(self, network, step)


def _read(part: Continuation) -> set[Knot]:
    """The knots whose data are read as such: a derivative of an angle is its rate."""
    return {*part.signal, *(part.rate or ())} | {(place, max(d - 1, 0)) for place, d in part.angle}


class CouplingState:
    """A scheme on one network with one step: its matrices and its memory of former steps.

    data (rows, signals, ...): values and derivatives of the signals, one row for each knot in `rows`. end_inputs
    (nu, ...): the inputs of all subsystems at the end of the last step.
    """

    def __init__(self, scheme: Scheme, network: Network, step: float):
        self.scheme, self.network, self.step = scheme, network, step
        used = {(-k, 0) for k in range(scheme.reach + 1)} | _read(scheme.before)
        used |= _read(scheme.after) if scheme.after else set()
        self.rows = sorted(used, key=lambda knot: (knot[0] > 0, -knot[0], knot[1]))
        self.shape = (len(self.rows), len(network.signals))
        self.data = np.zeros(self.shape)
        self.slopes = [(self.rows.index(k), k[1]) for k in self.rows if k[0] == 0 and k[1] > 0]
        self.ends = [(self.rows.index(k), k[1]) for k in self.rows if k[0] == 1]
        self.past = [self.rows.index((-k, 0)) for k in range(scheme.reach + 1)]
        self.end_inputs = np.zeros(len(network.inputs))
        self.saved = [None] * len(network.parts)
        before = self._matrices(scheme.before)
        after = self._matrices(scheme.after) if scheme.after else before
        self.guess = (
            self._subsystem_matrices(before, after) if scheme.sequential else self._subsystem_matrices(before, before)
        )
        self.final = self._subsystem_matrices(after, after)

    # The state of the discrete-time system besides those of the subsystems

    @property
    def memory(self) -> np.ndarray:
        """The signals of former steps (reach, signals, ...), the most recent first."""
        return self.data[self.past[1:]]

    @memory.setter
    def memory(self, values: np.ndarray) -> None:
        self.data = np.zeros((*self.shape, *values.shape[2:]))
        self.data[self.past[1:]] = values

    def start(self, outputs: np.ndarray) -> None:
        """Fill the memory with the signals extrapolated to times before the start, from `outputs`
        (ny,) at the start."""
        self.memory = past_signals(self.network, outputs, self.step, self.scheme.reach)

    # One step

    def advance(self, outputs: np.ndarray) -> np.ndarray:
        """Step all subsystems from where `outputs` (ny, ...) were read; the outputs after the step."""
        network, data = self.network, self.data
        data[0] = outputs[network.signal_outputs]
        self.end_inputs = (
            np.zeros((len(network.inputs), *outputs.shape[1:]))
            if self.end_inputs.shape[1:] != outputs.shape[1:]
            else self.end_inputs
        )
        if self.slopes:
            network.settle(outputs)
            found = network.slopes(self.scheme.slopes_needed, outputs.shape[1:])
            for row, derivative in self.slopes:
                data[row] = found[derivative - 1]
        if self.scheme.iterated:
            outputs = self._iterate(outputs)
        else:
            self._step(self.guess, outputs)
            outputs = network.read(outputs, end=1)
        for older, newer in zip(self.past[:0:-1], self.past[-2::-1], strict=True):
            data[older] = data[newer]
        return outputs

    def _step(self, matrices: list[np.ndarray], outputs: np.ndarray) -> None:
        """Step every subsystem once; in a sequential coupling read a subsystem before the next one steps."""
        network, columns = self.network, outputs.shape[1:]
        for index, (subsystem, u, y) in enumerate(network.parts):
            flat = matrices[index] @ self.data.reshape(matrices[index].shape[1], *columns)
            coefficients = flat.reshape(COEFFICIENTS, len(subsystem.inputs), *columns)
            network.add_external(coefficients, index)
            self.end_inputs[u] = coefficients.sum(axis=0)
            subsystem.step(coefficients, self.step)
            if self.scheme.sequential:
                outputs[y] = subsystem.exchange(self.end_inputs[u])
                self.data[self.ends[0][0], network.owner == index] = outputs[
                    network.signal_outputs[network.owner == index]
                ]

    def _iterate(self, outputs: np.ndarray) -> np.ndarray:
        """Repeat the step until the outputs at its end agree with the inputs that it was made with."""
        network = self.network
        self.saved = [subsystem.save(into) for (subsystem, _, _), into in zip(network.parts, self.saved, strict=True)]
        matrices = self.guess
        for _ in range(PASSES):
            self._step(matrices, outputs)
            outputs = network.read(outputs, end=1)
            former = self.data[[row for row, _ in self.ends]]
            self._read_ends(outputs)
            now = self.data[[row for row, _ in self.ends]]
            if matrices is self.final and np.abs(now - former).max(initial=0.0) <= CONVERGED * np.abs(now).max(
                initial=0.0
            ):
                return outputs
            matrices = self.final
            for (subsystem, _, _), state in zip(network.parts, self.saved, strict=True):
                subsystem.restore(state)
        raise StepTooLongError(f"the iteration of {self.scheme.name} does not converge at a step of {self.step:g} s")

    def _read_ends(self, outputs: np.ndarray) -> None:
        highest = max(derivative for _, derivative in self.ends)
        if highest:
            self.network.settle(outputs, end=1)
            found = self.network.slopes(highest, outputs.shape[1:])
        for row, derivative in self.ends:
            self.data[row] = found[derivative - 1] if derivative else outputs[self.network.signal_outputs]

    # The matrices

    def _matrices(self, part: Continuation) -> np.ndarray:
        """(signals, 4, rows, signals): the polynomial of each signal from the data."""
        matrices = [self._signal(part, j) for j in range(len(self.network.signals))]
        return np.array(matrices).reshape(len(matrices), COEFFICIENTS, *self.shape)

    def _subsystem_matrices(self, ahead: np.ndarray, behind: np.ndarray) -> list[np.ndarray]:
        """For each subsystem (4 nu, rows signals): `behind` where the source steps before the
        subsystem, else `ahead`."""
        network, matrices = self.network, []
        for index, (subsystem, u, _) in enumerate(network.parts):
            used = np.flatnonzero(network.wires[u].any(axis=0))
            stepped = (network.owner[used] < index)[:, None, None, None]
            whole = np.einsum("uj,jkrm->kurm", network.wires[u][:, used], np.where(stepped, behind[used], ahead[used]))
            projected = np.einsum("lk,kurm->lurm", nearest(subsystem.input_order), whole)
            matrices.append(projected.reshape(COEFFICIENTS * len(subsystem.inputs), int(np.prod(self.shape))))
        return matrices

    def _signal(self, part: Continuation, j: int) -> np.ndarray:
        """(4, rows, signals): the polynomial of one signal from the data."""
        rate, angle = self.network.rate_of(j), self.network.angle_of(j)
        weights = np.zeros((COEFFICIENTS, *self.shape))
        if angle is not None and part.angle and part.rate is None:
            whole = self._signal(part, angle)
            weights[:-1] = whole[1:] * np.arange(1, COEFFICIENTS)[:, None, None] / self.step
            return weights
        knots = (
            part.angle
            if rate is not None and part.angle
            else part.rate
            if angle is not None and part.rate
            else part.signal
        )
        for column, (place, derivative) in zip(through(knots).T, knots, strict=True):
            row, source = (
                ((place, derivative - 1), rate) if rate is not None and derivative else ((place, derivative), j)
            )
            weights[:, self.rows.index(row), source] += column * self.step**derivative
        return weights

