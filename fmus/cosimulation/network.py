"""Connected subsystems: every input is a sum of outputs, or is external.

Outputs are read in the order of their dependence, so that direct feed-through uses present inputs. An algebraic loop is
refused, with the variables of the loop in the message.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from fmus.cosimulation.polynomials import nearest
from fmus.cosimulation.subsystems.subsystem import Subsystem
from fmus.declaration.units import unit as known_unit
from fmus.linear_analysis.linearisation import StateSpace
from fmus.support.errors import InputError, unknown


class Network:
    """Subsystems by name, and `wiring`: input -> sources, both as `subsystem.variable`.

    `signals` are the outputs that drive an input, in the order of the subsystems. Inputs and outputs of all subsystems
    lie in one vector each, u = wires y + external; `parts` gives a subsystem's slices of them. `external` has the
    values at the start and at the end of a step, linear in between; at first the subsystems' own values.
    """

    def __init__(self, subsystems: Mapping[str, Subsystem], wiring: Mapping[str, Sequence[str]]):
        self.subsystems = dict(subsystems)
        self.inputs = [f"{n}.{i}" for n, u in self.subsystems.items() for i in u.inputs]
        self.outputs = [f"{n}.{o}" for n, u in self.subsystems.items() for o in u.outputs]
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
        self.signal_outputs = np.array([self.outputs.index(s) for s in self.signals], int)
        self.wires = np.zeros((len(self.inputs), len(self.signals)))
        for target, sources in self.wiring.items():
            for source in sources:
                self.wires[self.inputs.index(target), self.signals.index(source)] += 1.0
        present = [subsystem.present_inputs for subsystem in self.subsystems.values()]
        free = [name not in self.wiring for name in self.inputs]
        self.external = np.tile(np.where(free, np.concatenate([np.zeros(0), *present]), 0.0), (2, 1))
        self.parts = self._parts()
        self.owner = np.array([list(self.subsystems).index(s.partition(".")[0]) for s in self.signals], int)
        self.read_order, self.sets_inputs, self.unsettled = self._read_order()
        self.drives, self.drive_of = self._drives()

    def _same_units(self, source: str, target: str) -> None:
        """Raises InputError where the two have different units of measure."""
        given, wanted = self.unit_of(source), self.unit_of(target)
        if not agree(given, wanted):
            raise InputError(f"{source} [{given}] cannot drive {target} [{wanted}]: the units differ")

    def unit_of(self, name: str) -> str:
        """The unit of `subsystem.variable`; an empty text where it is unknown."""
        subsystem, _, variable = name.partition(".")
        return self.subsystems[subsystem].unit_of(variable)

    def _parts(self) -> list[tuple[Subsystem, slice, slice]]:
        """For each subsystem: itself, its inputs, its outputs."""
        parts, iu, iy = [], 0, 0
        for subsystem in self.subsystems.values():
            parts.append((subsystem, slice(iu, iu + len(subsystem.inputs)), slice(iy, iy + len(subsystem.outputs))))
            iu, iy = iu + len(subsystem.inputs), iy + len(subsystem.outputs)
        return parts

    def _read_order(self) -> tuple[list[int], list[bool], list[int]]:
        """The order of subsystems in which outputs are read until all are valid, and whether inputs are set before.

        Also the subsystems whose inputs are not all up to date after that.
        """
        driven = self.wires != 0
        known = np.zeros(len(self.outputs), bool)
        order: list[int] = []
        sets: list[bool] = []
        settled: set[int] = set()
        while not known.all():
            inputs_known = ~(driven & ~known[self.signal_outputs]).any(axis=1)
            for index, (subsystem, u, y) in enumerate(self.parts):
                new = ~(subsystem.feedthrough & ~inputs_known[u]).any(axis=1) & ~known[y]
                if new.any():
                    order.append(index)
                    sets.append(bool(subsystem.feedthrough[new].any()))
                    settled |= {index} if sets[-1] and inputs_known[u].all() else set()
                    known[y] |= new
                    break
            else:
                raise InputError(
                    f"algebraic loop: {self._loop(known)}; break it with a delay, or join the parts into one FMU"
                )
        return order, sets, [i for i in range(len(self.parts)) if i not in settled]

    def _drives(self) -> tuple[np.ndarray, np.ndarray]:
        """The different sums of signals that drive inputs, as rows (drives, signals), and for each
        input which one does."""
        if not len(self.inputs):
            return np.zeros((0, len(self.signals))), np.zeros(0, int)
        rows, of = np.unique(self.wires, axis=0, return_inverse=True)
        return rows, of.ravel()

    def _loop(self, known: np.ndarray) -> str:
        path = [self.outputs[int(np.flatnonzero(~known)[0])]]
        while path.count(path[-1]) == 1:
            name, _, output = path[-1].partition(".")
            subsystem = self.subsystems[name]
            needs = [
                f"{name}.{i}"
                for i, f in zip(subsystem.inputs, subsystem.feedthrough[subsystem.outputs.index(output)], strict=True)
                if f
            ]
            path.append(next(s for i in needs for s in self.wiring.get(i, ()) if not known[self.outputs.index(s)]))
        return " <- ".join(path[path.index(path[-1]) :])

    def read(self, outputs: np.ndarray, end: int = 0) -> np.ndarray:
        """Set all inputs and read all outputs into `outputs` (ny, ...), which is returned; end 1 after a step."""
        for index in self.read_order:
            subsystem, u, y = self.parts[index]
            outputs[y] = subsystem.exchange(self._inputs(outputs, u, end))
        return outputs

    def settle(self, outputs: np.ndarray, end: int = 0) -> None:
        """Set the inputs that were not known when `read` set inputs, so that state rates are those
        of the present time."""
        for index in self.unsettled:
            subsystem, u, _ = self.parts[index]
            subsystem.exchange(self._inputs(outputs, u, end))

    def _inputs(self, outputs: np.ndarray, u: slice, end: int) -> np.ndarray:
        inputs = self.wires[u] @ outputs[self.signal_outputs]
        return (inputs.T + self.external[end, u]).T

    def add_external(self, coefficients: np.ndarray, index: int) -> None:
        """Add the external inputs to the polynomials (4, nu, ...) of a subsystem's inputs."""
        subsystem, u, _ = self.parts[index]
        first, last = self.external[:, u]
        line = nearest(subsystem.input_order)[:, :2] @ np.stack([first, last - first])
        coefficients += line.reshape(*line.shape, *[1] * (coefficients.ndim - 2))

    def slopes(self, order: int, shape: tuple[int, ...] = ()) -> np.ndarray:
        """The signals' derivatives with respect to time (order, signals, ...), after `read` and `settle`."""
        found = np.zeros((order, len(self.outputs), *shape))
        for k in range(order):
            for index in self.read_order:
                subsystem, u, y = self.parts[index]
                inputs = np.stack([self.wires[u] @ found[j, self.signal_outputs] for j in range(k + 1)])
                found[k, y] = subsystem.output_slope(inputs)
        return found[:, self.signal_outputs]

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
        """All subsystems as one linear model: states `subsystem.state`, the inputs that nothing drives, all outputs.

        With u = W y + w:  y = (1 - D W)^-1 (C x + D w),  x' = A x + B (W y + w).
        """
        spaces = [subsystem.linearised() for subsystem in self.subsystems.values()]
        A, B, C, D = (block_diagonal([getattr(s, m) for s in spaces]) for m in "ABCD")
        wires = np.zeros((len(self.inputs), len(self.outputs)))
        wires[:, self.signal_outputs] = self.wires
        closed = np.linalg.inv(np.eye(len(self.outputs)) - D @ wires)
        free = [k for k, name in enumerate(self.inputs) if name not in self.wiring]
        states = tuple(f"{n}.{x}" for n, s in zip(self.subsystems, spaces, strict=True) for x in s.states)
        return StateSpace(A + B @ wires @ closed @ C, (B + B @ wires @ closed @ D)[:, free], closed @ C,
                          (closed @ D)[:, free], states, tuple(self.inputs[k] for k in free),
                          tuple(self.outputs))  # fmt: skip


def agree(given: str, wanted: str) -> bool:
    """Whether a number in one unit of measure can be taken for one in the other; unknown units agree by name alone."""
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
