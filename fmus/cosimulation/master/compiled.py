"""The loop over the steps compiled, called once for many steps: see master.c.

The coupling computes matrices, orders and connections in Python; this module passes their addresses to C. Within a run
only a new linearisation returns to Python.
"""

from ctypes import c_void_p, cast
from typing import Any

import numpy as np

from fmus.cosimulation.coupling.interface_jacobian import LOOK, MISSED, InterfaceJacobianState
from fmus.cosimulation.master.library import array, library, pointer, structures
from fmus.cosimulation.network import Network
from fmus.cosimulation.polynomials import COEFFICIENTS, derivatives
from fmus.cosimulation.scheme import CONVERGED, PASSES, CouplingState
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.support.errors import EndRequestedError, SimulationError

CHUNK, VALUES = 4000, 60_000  # steps and numbers written between two returns to Python: few enough to stay in the cache


def can_compile(network: Network) -> bool:
    """Whether all subsystems are FMUs."""
    return all(isinstance(subsystem, FmuSubsystem) for subsystem, _, _ in network.parts)


class CompiledMaster:
    """Runs a prepared coupling. `done` counts the steps of the last call that were made.

    Raises MissingToolError when there is no C compiler.
    """

    def __init__(self, network: Network, state: CouplingState | InterfaceJacobianState):
        self.network, self.state, self.done = network, state, 0
        self.subsystems = [subsystem for subsystem, _, _ in network.parts if isinstance(subsystem, FmuSubsystem)]
        self.chunk = min(CHUNK, max(50, VALUES // (len(network.outputs) + len(network.inputs) + 1)))
        self._library = library()
        self._alive: list[Any] = []  # what the structures point to
        n_data = state.data.size if isinstance(state, CouplingState) else state.expected.shape[1]
        self._data, self.outputs = np.zeros(n_data), np.zeros(len(network.outputs))
        self.c = structures().new("Master *", {
            "n_subsystems": len(self.subsystems), "n_inputs": len(network.inputs), "n_outputs": len(network.outputs),
            "n_signals": len(network.signals), "n_data": n_data, "step_size": state.step,
            "missed": MISSED, "converged": CONVERGED, "passes": PASSES, "look": LOOK,
            "data": self._kept("double", self._data), "last": self._kept("double", self.outputs),
        })  # fmt: skip
        self._describe_network()
        self._allocate(n_data)
        if isinstance(state, CouplingState):
            self._describe_scheme(state)
        else:
            self._describe_interface_jacobian(state)
        self._lasting = len(self._alive)
        self._prepare()

    def _describe_network(self) -> None:
        """Which outputs drive an input, and in which order outputs are read."""
        c, network = self.c, self.network
        wires = [np.flatnonzero(row) for row in network.wires]
        wired = np.concatenate([np.zeros(0, int), *wires])
        c.signal_outputs = self._sizes(network.signal_outputs)
        c.wire_start, c.wires, c.sources = (
            self._sizes(np.cumsum([0, *map(len, wires)])),
            self._sizes(wired),
            self._sizes(network.signal_outputs[wired]),
        )
        c.read_order, c.sets_inputs = self._sizes(network.read_order), self._sizes(network.sets_inputs)
        c.rates_too, c.n_reads = self._sizes(np.zeros(len(network.read_order))), len(network.read_order)
        c.unsettled, c.n_unsettled = self._sizes(network.unsettled), len(network.unsettled)

    def _allocate(self, n_data: int) -> None:
        """Memory for intermediate results of the loop."""
        c, network = self.c, self.network
        largest = max((5 * len(u.inputs) + 2 * len(u.states) + len(u.outputs) for u in self.subsystems), default=0)
        sizes = {
            "slopes": 3 * len(network.outputs),
            "scratch": largest,
            "former": n_data,
            "rates": n_data,
            "change": len(network.drives) + self._library.BLOCK,
        }
        for name, size in sizes.items():
            setattr(c, name, self._doubles(np.zeros(size + 1)))

    def _describe_scheme(self, state: CouplingState) -> None:
        """The rows of the data: former values, derivatives, values at the end of the step."""
        c, scheme = self.c, state.scheme
        c.sequential, c.iterated = scheme.sequential, scheme.iterated
        c.past, c.n_past = self._sizes(state.past), len(state.past)
        for rows, name in ((state.slopes, "slope"), (state.ends, "end")):
            setattr(c, f"{name}_rows", self._sizes([row for row, _ in rows]))
            setattr(c, f"{name}_derivatives", self._sizes([derivative for _, derivative in rows]))
        c.n_slopes, c.n_ends = len(state.slopes), len(state.ends)

    def _describe_interface_jacobian(self, state: InterfaceJacobianState) -> None:
        """The data are the signals, the states' rates and the slopes of the free inputs."""
        c, network = self.c, self.network
        c.past, c.n_past = self._sizes([0]), 1
        c.rates_at, c.n_free, c.free_inputs = len(network.signals), len(state.free), self._sizes(state.free)
        last = {
            subsystem: place for place, subsystem in enumerate(network.read_order) if subsystem not in network.unsettled
        }
        c.rates_too = self._sizes([last.get(subsystem) == place for place, subsystem in enumerate(network.read_order)])
        self._expected = np.flatnonzero(network.drives.any(axis=1))
        c.n_expected, c.expected_inputs = (
            len(self._expected),
            self._sizes([network.drive_of.tolist().index(k) for k in self._expected]),
        )

    def _kept(self, kind: str, values: np.ndarray) -> Any:
        """The memory of an array, which lives as long as the loop."""
        self._alive.append(array(kind, values))
        return self._alive[-1]

    def _sizes(self, values: Any) -> Any:
        return self._kept("size_t", np.ascontiguousarray(values, np.uintp))

    def _doubles(self, values: np.ndarray) -> Any:
        return self._kept("double", np.ascontiguousarray(values, float))

    def _matrix(self, rows: np.ndarray, order: int = 0) -> Any:
        """A Matrix: only the columns that are not zero, since with many subsystems an input depends
        on few of the data."""
        block = self._library.BLOCK
        columns = np.flatnonzero(rows.any(axis=0))
        padded = np.pad(rows[:, columns], ((0, -len(rows) % block), (0, 0)))
        blocks = padded.reshape(len(padded) // block, block, len(columns)).swapaxes(1, 2)
        return {
            "order": order,
            "n_columns": len(columns),
            "columns": self._sizes(columns),
            "blocks": self._doubles(blocks),
        }

    def _polynomials(self, subsystem: FmuSubsystem, matrix: np.ndarray) -> Any:
        """The Matrix from the data to the coefficients of a subsystem's inputs."""
        rows = matrix.reshape(COEFFICIENTS, len(subsystem.inputs), matrix.shape[1])
        order = int(np.flatnonzero(rows.any(axis=(1, 2))).max(initial=0))
        scaled = rows if subsystem.calls.path else derivatives(rows, self.state.step)
        return self._matrix(scaled[: order + 1].reshape((order + 1) * len(subsystem.inputs), matrix.shape[1]), order)

    def _prepare(self) -> None:
        """Fill the structures of the subsystems; repeated after a new linearisation, which changes the matrices."""
        state = self.state
        if isinstance(state, InterfaceJacobianState):
            self.c.expected = self._matrix(state.expected[self._expected])
        guess, final = (
            (state.guess, state.final) if isinstance(state, CouplingState) else (state.matrices, state.matrices)
        )
        subsystems = structures().new("Subsystem[]", len(self.subsystems))
        first_with: dict[bytes, int] = {}
        first_state = 0
        for k, (subsystem, (_, u, y)) in enumerate(zip(self.subsystems, self.network.parts, strict=True)):
            c, calls = subsystems[k], subsystem.calls
            like = k if calls.path else first_with.setdefault(guess[k].tobytes() + final[k].tobytes(), k)
            if like == k:
                c.guess, c.final = self._polynomials(subsystem, guess[k]), self._polynomials(subsystem, final[k])
                c.coefficients = (
                    calls.path.coefficients
                    if calls.path
                    else self._doubles(np.zeros(COEFFICIENTS * len(subsystem.inputs)))
                )
            else:
                c.guess, c.final, c.coefficients = (
                    subsystems[like].guess,
                    subsystems[like].final,
                    subsystems[like].coefficients,
                )
            c.instance, c.version, c.like, c.order = (
                pointer("void", calls.fmu.component),
                calls.version,
                like,
                subsystem.input_order,
            )
            c.path, c.ended = calls.path or structures().NULL, self._doubles(np.zeros(1))
            c.calls = [
                structures().cast("Function", cast(getattr(calls.fmu.dll, name), c_void_p).value if name else 0)
                for name in calls.functions
            ]
            c.n_inputs, c.n_outputs, c.n_states = len(subsystem.inputs), len(subsystem.outputs), len(subsystem.states)
            c.first_input, c.first_output, c.first_state = u.start, y.start, first_state
            for name, (kind, values) in subsystem.references().items():
                setattr(c, name, self._kept(kind, values))
            if isinstance(state, CouplingState) and state.scheme.iterated:
                c.saved = pointer("void", subsystem.save()[0].value)
            first_state += len(subsystem.states)
        self._alive.append(subsystems)
        self.c.subsystems = subsystems

    def begin(self, outputs: np.ndarray) -> None:
        """Set the outputs (ny,) at the start of the run."""
        self.outputs[:] = outputs
        if isinstance(self.state, CouplingState):
            self._data[:] = self.state.data.ravel()
        self.c.time = self.subsystems[0].time if self.subsystems else 0.0

    def steps(self, external: np.ndarray, outputs: np.ndarray, end_inputs: np.ndarray) -> None:
        """n steps with external inputs (n + 1, nu); writes outputs (n, ny) and the inputs at the
        end of each step (n, nu).

        Raises SimulationError when an FMU refuses a step or an iteration does not converge.
        """
        self.done = 0
        count = len(external) - 1
        if external.strides[1:] != (8,):
            external = np.ascontiguousarray(external)
        self.c.row = external.strides[0] // 8
        while self.done < count:
            k = self.done
            given, rows, ends = (
                pointer("double", values[k:].ctypes.data) for values in (external, outputs, end_inputs)
            )
            self.done += self._library.master_run(self.c, count - k, given, rows, outputs.strides[0] // 8, ends)
            for subsystem in self.subsystems:
                subsystem.time = self.c.time
            if self.c.status:
                self._fail()
            if self.c.renew and isinstance(self.state, InterfaceJacobianState):
                self._renew(external[self.done])

    def _fail(self) -> None:
        c, subsystem = self.c, self.subsystems[self.c.failed_subsystem]
        if c.status < 0:
            raise SimulationError("the iteration does not converge")
        if c.status == self._library.STOPPED:
            raise SimulationError(f"{subsystem.name} has ended the step from {c.time:g} s early")
        if c.status == self._library.ENDED:
            raise EndRequestedError(subsystem.name, c.subsystems[c.failed_subsystem].ended[0])
        subsystem.calls.fail(subsystem.calls.functions[c.call], c.status)

    def _renew(self, external: np.ndarray) -> None:
        """Linearise again at the present states, with the present external inputs (nu,)."""
        assert isinstance(self.state, InterfaceJacobianState)
        self.network.external[:] = external
        self.network.read(self.outputs)
        self.network.settle(self.outputs)
        del self._alive[self._lasting :]
        self.state.renew()
        self._prepare()
