"""Units wired together: every input is a sum of outputs, or comes from outside.

Feed-through is resolved in the order of dependence, so that no output is ever read with yesterday's inputs. A
loop of feed-through is refused and spelled port by port.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from fmus.coupling.polynomials import nearest
from fmus.coupling.units import Unit
from fmus.errors import InputError, unknown
from fmus.linear import StateSpace
from fmus.units import unit as known_unit


class Network:
    """Units by name, and `wiring`: input -> sources, both as `unit.variable`.

    `signals` are the outputs that drive something, in the order of the units. Inputs and outputs of all units
    lie in one vector each, u = wires y + external; `part` gives a unit's place in them. `external` has the
    values at the start and at the end of a step, with a straight line between; at first those the units have.
    """

    def __init__(self, units: Mapping[str, Unit], wiring: Mapping[str, Sequence[str]]):
        self.units = dict(units)
        self.inputs = [f"{n}.{i}" for n, u in self.units.items() for i in u.inputs]
        self.outputs = [f"{n}.{o}" for n, u in self.units.items() for o in u.outputs]
        self.wiring = {target: tuple(sources) for target, sources in wiring.items()}
        for target, sources in self.wiring.items():
            if target not in self.inputs:
                raise unknown("input", target, self.inputs)
            for source in sources:
                if source not in self.outputs:
                    raise unknown("output", source, self.outputs)
                self._same_units(source, target)
        used = {source for sources in self.wiring.values() for source in sources}
        self.signals = [o for o in self.outputs if o in used]
        self.where = np.array([self.outputs.index(s) for s in self.signals], int)
        self.wires = np.zeros((len(self.inputs), len(self.signals)))
        for target, sources in self.wiring.items():
            for source in sources:
                self.wires[self.inputs.index(target), self.signals.index(source)] += 1.0
        present = [unit.present_inputs for unit in self.units.values()]
        free = [name not in self.wiring for name in self.inputs]
        self.external = np.tile(np.where(free, np.concatenate([np.zeros(0), *present]), 0.0), (2, 1))
        self.part = self._parts()
        self.owner = np.array([list(self.units).index(s.partition(".")[0]) for s in self.signals], int)
        self.rounds, self.sets, self.late = self._rounds()
        self.drives, self.drive_of = self._drives()

    def _same_units(self, source: str, target: str) -> None:
        """Raises InputError where the two have different units."""
        given, wanted = (self.units[n].unit_of(variable) for n, _, variable in (source.partition("."), target.partition(".")))
        if not agree(given, wanted):
            raise InputError(f"{source} [{given}] cannot drive {target} [{wanted}]: the units differ")

    def _parts(self) -> list[tuple[Unit, slice, slice]]:
        """For each unit: itself, its inputs, its outputs."""
        parts, iu, iy = [], 0, 0
        for unit in self.units.values():
            parts.append((unit, slice(iu, iu + len(unit.inputs)), slice(iy, iy + len(unit.outputs))))
            iu, iy = iu + len(unit.inputs), iy + len(unit.outputs)
        return parts

    def _rounds(self) -> tuple[list[int], list[bool], list[int]]:
        """Units in the order in which to read outputs until every output is right, and whether to set inputs before.

        And those whose inputs have not all been set to what they are when everything has been read.
        """
        driven = self.wires != 0
        known = np.zeros(len(self.outputs), bool)
        order: list[int] = []
        sets: list[bool] = []
        settled: set[int] = set()
        while not known.all():
            inputs_known = ~(driven & ~known[self.where]).any(axis=1)
            for index, (unit, u, y) in enumerate(self.part):
                new = ~(unit.feedthrough & ~inputs_known[u]).any(axis=1) & ~known[y]
                if new.any():
                    order.append(index)
                    sets.append(bool(unit.feedthrough[new].any()))
                    settled |= {index} if sets[-1] and inputs_known[u].all() else set()
                    known[y] |= new
                    break
            else:
                raise InputError(f"algebraic loop: {self._loop(known)}; break it with a delay, or join the parts into one FMU")
        return order, sets, [i for i in range(len(self.part)) if i not in settled]

    def _drives(self) -> tuple[np.ndarray, np.ndarray]:
        """The different sums of signals that drive inputs, as rows (drives, signals), and for each input which one does."""
        if not len(self.inputs):
            return np.zeros((0, len(self.signals))), np.zeros(0, int)
        rows, of = np.unique(self.wires, axis=0, return_inverse=True)
        return rows, of.ravel()

    def _loop(self, known: np.ndarray) -> str:
        path = [self.outputs[int(np.flatnonzero(~known)[0])]]
        while path.count(path[-1]) == 1:
            name, _, output = path[-1].partition(".")
            unit = self.units[name]
            needs = [f"{name}.{i}" for i, f in zip(unit.inputs, unit.feedthrough[unit.outputs.index(output)], strict=True) if f]
            path.append(next(s for i in needs for s in self.wiring.get(i, ()) if not known[self.outputs.index(s)]))
        return " <- ".join(path[path.index(path[-1]) :])

    def read(self, outputs: np.ndarray, end: int = 0) -> np.ndarray:
        """Set all inputs and read all outputs into `outputs` (ny, ...), which is returned; end 1 after a step."""
        for index in self.rounds:
            unit, u, y = self.part[index]
            outputs[y] = unit.exchange(self._inputs(outputs, u, end))
        return outputs

    def settle(self, outputs: np.ndarray, end: int = 0) -> None:
        """Set the inputs that were not known yet when `read` set them; for rates at the present time."""
        for index in self.late:
            unit, u, _ = self.part[index]
            unit.exchange(self._inputs(outputs, u, end))

    def _inputs(self, outputs: np.ndarray, u: slice, end: int) -> np.ndarray:
        inputs = self.wires[u] @ outputs[self.where]
        return (inputs.T + self.external[end, u]).T

    def add_external(self, coefficients: np.ndarray, index: int) -> None:
        """Add what comes from outside to the polynomials (4, nu, ...) of a unit's inputs."""
        unit, u, _ = self.part[index]
        first, last = self.external[:, u]
        line = nearest(unit.input_order)[:, :2] @ np.stack([first, last - first])
        coefficients += line.reshape(*line.shape, *[1] * (coefficients.ndim - 2))

    def slopes(self, order: int, shape: tuple[int, ...] = ()) -> np.ndarray:
        """The signals' derivatives with respect to time (order, signals, ...), after `read` and `settle`."""
        found = np.zeros((order, len(self.outputs), *shape))
        for k in range(order):
            for index in self.rounds:
                unit, u, y = self.part[index]
                inputs = np.stack([self.wires[u] @ found[j, self.where] for j in range(k + 1)])
                found[k, y] = unit.output_slope(inputs)
        return found[:, self.where]

    def rate_of(self, signal: int) -> int | None:
        """The signal that is the rate of a signal (`steer_rate` of `steer_angle`), if there is one."""
        return self._partner(signal, "_angle", "_rate")

    def angle_of(self, signal: int) -> int | None:
        """The signal whose rate a signal is, if there is one."""
        return self._partner(signal, "_rate", "_angle")

    def _partner(self, signal: int, ending: str, other: str) -> int | None:
        name = self.signals[signal]
        partner = name.removesuffix(ending) + other
        return self.signals.index(partner) if name.endswith(ending) and partner in self.signals else None

    def linearised(self) -> StateSpace:
        """All units as one linear model: states `unit.state`, the inputs that nothing drives, all outputs.

        With u = W y + w:  y = (1 - D W)^-1 (C x + D w),  x' = A x + B (W y + w).
        """
        spaces = [unit.linearised() for unit in self.units.values()]
        A, B, C, D = (block_diagonal([getattr(s, m) for s in spaces]) for m in "ABCD")
        wires = np.zeros((len(self.inputs), len(self.outputs)))
        wires[:, self.where] = self.wires
        closed = np.linalg.inv(np.eye(len(self.outputs)) - D @ wires)
        free = [k for k, name in enumerate(self.inputs) if name not in self.wiring]
        states = tuple(f"{n}.{x}" for n, s in zip(self.units, spaces, strict=True) for x in s.states)
        return StateSpace(A + B @ wires @ closed @ C, (B + B @ wires @ closed @ D)[:, free], closed @ C, (closed @ D)[:, free],
                          states, tuple(self.inputs[k] for k in free), tuple(self.outputs))  # fmt: skip


def agree(given: str, wanted: str) -> bool:
    """Whether a number in one unit can be taken for one in the other; units that nobody knows agree by name alone."""
    if not given or not wanted or given == wanted:
        return True
    try:
        first, second = known_unit(given), known_unit(wanted)
    except InputError:
        return False
    return (first.factor, first.exponents) == (second.factor, second.exponents)


def block_diagonal(matrices: Sequence[np.ndarray]) -> np.ndarray:
    """The matrices along a diagonal; empty ones count with their rows and columns."""
    whole = np.zeros((sum(m.shape[0] for m in matrices), sum(m.shape[1] for m in matrices)))
    i = j = 0
    for m in matrices:
        whole[i : i + m.shape[0], j : j + m.shape[1]] = m
        i, j = i + m.shape[0], j + m.shape[1]
    return whole
