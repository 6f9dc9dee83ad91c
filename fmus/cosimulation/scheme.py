"""A coupling: how each signal is continued over a step from what is known of it, and which unit steps when.

Every signal between the units becomes a polynomial over the step. What a coupling says is through which knots
it goes: `before` its source has stepped, and `after` (in a sequential coupling for the units behind the
source; in an iterated one for all units, from the second pass on). An angle whose rate is a signal too has its
own knots, its rate then being a knot's datum. All this is linear: the polynomials of a unit's inputs are one
matrix times the data, made once for a step size.
"""

from dataclasses import dataclass

import numpy as np

from fmus.coupling.history import past_signals
from fmus.coupling.network import Network
from fmus.coupling.polynomials import COEFFICIENTS, Knot, Knots, nearest, through
from fmus.errors import SimulationError

PASSES = 200
CONVERGED = 1e-10  # of the largest signal; rounding of what cancels in a torque is below


@dataclass(frozen=True)
class Continuation:
    """The knots of a signal; of an angle whose rate is a signal, and of such a rate, where they are others.

    `rate` None means the derivative of the angle's polynomial.
    """

    signal: Knots
    angle: Knots = ()
    rate: Knots | None = ()

    def knots(self) -> set[Knot]:
        return {*self.signal, *(self.angle or ()), *(self.rate or ())}


@dataclass(frozen=True)
class Scheme:
    """A coupling by its knots.

    order is that of the error over a given time in the step. stable are the largest stable steps [s] of the mean
    rider of the 2011 paper on a bar of 0.6 kg.m2 and on Sharp's motorcycle at 30 m/s, inf where that is beyond 1 s.
    """

    name: str
    summary: str
    order: int
    stable: tuple[float, float]
    source: str
    before: Continuation
    after: Continuation | None = None
    sequential: bool = False
    iterated: bool = False

    def lacks(self, network: Network) -> str:
        """What the units would have to offer for this coupling; empty when they can."""
        if self.iterated:
            names = [n for n, unit in network.units.items() if not unit.can_go_back]
            if names:
                return f"{' and '.join(names)} cannot save and restore the FMU state"
        wanted = self.slopes_needed
        names = [n for n, unit in network.units.items() if unit.output_order < wanted]
        if names:
            return f"{' and '.join(names)} cannot give derivatives of the outputs up to order {wanted}"
        return ""

    @property
    def slopes_needed(self) -> int:
        """Up to which derivative the outputs are read."""
        parts = [self.before, *([self.after] if self.after else [])]
        return max((d for part in parts for _, d in _read(part)), default=0)

    @property
    def reach(self) -> int:
        """How many steps the coupling remembers."""
        parts = [self.before, *([self.after] if self.after else [])]
        return max(-place for part in parts for place, _ in part.knots())

    def prepare(self, network: Network, step: float) -> "Run":
        return Run(self, network, step)


def _read(part: Continuation) -> set[Knot]:
    """The knots whose data are read as such: a derivative of an angle is its rate."""
    return {*part.signal, *(part.rate or ())} | {(place, max(d - 1, 0)) for place, d in part.angle}


class Run:
    """A scheme on one network with one step: its matrices and what it remembers.

    data (rows, signals, ...): what is known of the signals, one row for each knot in `rows`. told (nu, ...): the
    inputs of all units as they were told them for the end of the last step.
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
        self.told = np.zeros(len(network.inputs))
        self.saved = [None] * len(network.part)
        before = self._matrices(scheme.before)
        after = self._matrices(scheme.after) if scheme.after else before
        self.guess = self._unit_matrices(before, after) if scheme.sequential else self._unit_matrices(before, before)
        self.final = self._unit_matrices(after, after)

    # What the discrete-time system remembers besides the units' states

    @property
    def memory(self) -> np.ndarray:
        """The signals of former steps (reach, signals, ...), the last one first."""
        return self.data[self.past[1:]]

    @memory.setter
    def memory(self, values: np.ndarray) -> None:
        self.data = np.zeros((*self.shape, *values.shape[2:]))
        self.data[self.past[1:]] = values

    def start(self, outputs: np.ndarray) -> None:
        """Fill the memory with what the signals would have been before the start, where `outputs` (ny,) were read."""
        self.memory = past_signals(self.network, outputs, self.step, self.scheme.reach)

    # One step

    def advance(self, outputs: np.ndarray) -> np.ndarray:
        """Step all units from where `outputs` (ny, ...) were read; the outputs after the step."""
        network, data = self.network, self.data
        data[0] = outputs[network.where]
        self.told = np.zeros((len(network.inputs), *outputs.shape[1:])) if self.told.shape[1:] != outputs.shape[1:] else self.told
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
        """Step every unit once; in a sequential coupling read a unit before the next one steps."""
        network, columns = self.network, outputs.shape[1:]
        for index, (unit, u, y) in enumerate(network.part):
            flat = matrices[index] @ self.data.reshape(matrices[index].shape[1], *columns)
            coefficients = flat.reshape(COEFFICIENTS, len(unit.inputs), *columns)
            network.add_external(coefficients, index)
            self.told[u] = coefficients.sum(axis=0)
            unit.step(coefficients, self.step)
            if self.scheme.sequential:
                outputs[y] = unit.exchange(self.told[u])
                self.data[self.ends[0][0], network.owner == index] = outputs[network.where[network.owner == index]]

    def _iterate(self, outputs: np.ndarray) -> np.ndarray:
        """Repeat the step until what the units answer at its end is what they were told."""
        network = self.network
        self.saved = [unit.save(into) for (unit, _, _), into in zip(network.part, self.saved, strict=True)]
        matrices = self.guess
        for _ in range(PASSES):
            self._step(matrices, outputs)
            outputs = network.read(outputs, end=1)
            former = self.data[[row for row, _ in self.ends]]
            self._read_ends(outputs)
            now = self.data[[row for row, _ in self.ends]]
            if matrices is self.final and np.abs(now - former).max(initial=0.0) <= CONVERGED * np.abs(now).max(initial=0.0):
                return outputs
            matrices = self.final
            for (unit, _, _), state in zip(network.part, self.saved, strict=True):
                unit.restore(state)
        raise SimulationError(f"the iteration of {self.scheme.name} does not converge at a step of {self.step:g} s; take a smaller step")

    def _read_ends(self, outputs: np.ndarray) -> None:
        highest = max(derivative for _, derivative in self.ends)
        if highest:
            self.network.settle(outputs, end=1)
            found = self.network.slopes(highest, outputs.shape[1:])
        for row, derivative in self.ends:
            self.data[row] = found[derivative - 1] if derivative else outputs[self.network.where]

    # The matrices

    def _matrices(self, part: Continuation) -> np.ndarray:
        """(signals, 4, rows, signals): the polynomial of each signal from the data."""
        matrices = [self._signal(part, j) for j in range(len(self.network.signals))]
        return np.array(matrices).reshape(len(matrices), COEFFICIENTS, *self.shape)

    def _unit_matrices(self, ahead: np.ndarray, behind: np.ndarray) -> list[np.ndarray]:
        """For each unit (4 nu, rows signals): `behind` where the source steps before the unit, else `ahead`."""
        network, matrices = self.network, []
        for index, (unit, u, _) in enumerate(network.part):
            used = np.flatnonzero(network.wires[u].any(axis=0))
            stepped = (network.owner[used] < index)[:, None, None, None]
            whole = np.einsum("uj,jkrm->kurm", network.wires[u][:, used], np.where(stepped, behind[used], ahead[used]))
            projected = np.einsum("lk,kurm->lurm", nearest(unit.input_order), whole)
            matrices.append(projected.reshape(COEFFICIENTS * len(unit.inputs), -1))
        return matrices

    def _signal(self, part: Continuation, j: int) -> np.ndarray:
        """(4, rows, signals): the polynomial of one signal from the data."""
        rate, angle = self.network.rate_of(j), self.network.angle_of(j)
        weights = np.zeros((COEFFICIENTS, *self.shape))
        if angle is not None and part.angle and part.rate is None:
            whole = self._signal(part, angle)
            weights[:-1] = whole[1:] * np.arange(1, COEFFICIENTS)[:, None, None] / self.step
            return weights
        knots = part.angle if rate is not None and part.angle else part.rate if angle is not None and part.rate else part.signal
        for column, (place, derivative) in zip(through(knots).T, knots, strict=True):
            row, source = ((place, derivative - 1), rate) if rate is not None and derivative else ((place, derivative), j)
            weights[:, self.rows.index(row), source] += column * self.step**derivative
        return weights

