"""The loop over the steps compiled, called once for many steps: see master.c.

The matrices, orders and wires are those that the coupling made in Python; here they become addresses. Only a new
linearisation needs Python within a run.
"""

from ctypes import Structure, byref, c_double, c_int, c_size_t, c_void_p, cast
from typing import Any

import numpy as np

from fmus.coupling import Network
from fmus.coupling.interface_jacobian import LOOK, MISSED, Prediction
from fmus.coupling.polynomials import COEFFICIENTS, derivatives
from fmus.coupling.scheme import CONVERGED, PASSES, Run
from fmus.errors import SimulationError
from fmus.importer import FmuUnit
from fmus.loop_library import library

STOPPED, BLOCK = 100, 4  # as in unit.h and master.c


def _fields(**groups: Any) -> list[tuple[str, Any]]:
    return [(name, kind) for kind, names in groups.values() for name in names.split()]


class _Matrix(Structure):
    _fields_ = _fields(a=(c_size_t, "order n_columns"), b=(c_void_p, "columns blocks"))


class _Unit(Structure):
    _fields_ = _fields(
        a=(c_void_p, "instance saved path"), b=(c_size_t, "version"), c=(c_void_p * 8, "calls"),
        d=(c_size_t, "n_inputs n_outputs n_states order first_input first_output first_state like"),
        e=(c_void_p, "coefficients unknowns knowns slope_inputs slope_orders output_orders"), f=(_Matrix, "guess final"),
    )  # fmt: skip


class _Master(Structure):
    _fields_ = _fields(
        a=(c_size_t, "n_units n_inputs n_outputs n_signals n_data"), b=(c_void_p, "units where wire_start wires sources rounds sets rates_too late"),
        c=(c_size_t, "n_rounds n_late"), d=(c_void_p, "past slope_rows slope_derivatives end_rows end_derivatives"),
        e=(c_size_t, "n_past n_slopes n_ends"), f=(c_void_p, "free_inputs"), g=(c_size_t, "rates_at n_free n_expected"), h=(_Matrix, "expected"), o=(c_void_p, "expected_inputs"),
        i=(c_double, "missed converged step_size time"), j=(c_int, "sequential iterated passes"),
        p=(c_size_t, "row look count"), k=(c_void_p, "data last now told slopes scratch former rates change"), l=(c_size_t, "failed_unit"), m=(c_int, "status call renew"),
    )  # fmt: skip


def can_compile(network: Network) -> bool:
    """Whether all units are FMUs."""
    return all(isinstance(unit, FmuUnit) for unit, _, _ in network.part)


class CompiledMaster:
    """Runs a prepared coupling. `done` counts the steps of the last call that were made.

    Raises MissingToolError when there is no C compiler.
    """


    def __init__(self, network: Network, running: Run | Prediction):
        self.network, self.running, self.done = network, running, 0
        self.units = [unit for unit, _, _ in network.part if isinstance(unit, FmuUnit)]
        # Steps between two looks from outside: few enough for their rows to stay in the cache.
        self.chunk = min(4000, max(50, 60_000 // (len(network.outputs) + len(network.inputs) + 1)))
        self._run = library().master_run
        self._alive: list[Any] = []  # what the structures point to
        n_data = running.data.size if isinstance(running, Run) else running.expected.shape[1]
        wires = [np.flatnonzero(row) for row in network.wires]
        wired = np.concatenate([np.zeros(0, int), *wires])
        self._data, self.outputs = np.zeros(n_data), np.zeros(len(network.outputs))
        called = max((4 * len(u.inputs) + 2 * len(u.states) + len(u.inputs) + len(u.outputs) for u in self.units), default=0)
        self.c = _Master(
            len(self.units), len(network.inputs), len(network.outputs), len(network.signals), n_data, None, self._sizes(network.where),
            self._sizes(np.cumsum([0, *map(len, wires)])), self._sizes(wired), self._sizes(network.where[wired]),
            self._sizes(network.rounds), self._sizes(network.sets), self._sizes(np.zeros(len(network.rounds))), self._sizes(network.late),
            len(network.rounds), len(network.late),
            missed=MISSED, converged=CONVERGED, step_size=running.step, passes=PASSES, look=LOOK, data=self._data.ctypes.data, last=self.outputs.ctypes.data,
            slopes=self._doubles(np.zeros(3 * len(network.outputs) + 1)), scratch=self._doubles(np.zeros(called + 1)), former=self._doubles(np.zeros(n_data + 1)), rates=self._doubles(np.zeros(n_data + 1)), change=self._doubles(np.zeros(len(network.drives) + BLOCK)),
        )  # fmt: skip
        if isinstance(running, Run):
            self._describe_scheme(running)
        else:
            self._describe_prediction(running)
        self._lasting = len(self._alive)
        self._prepare()

    def _describe_scheme(self, running: Run) -> None:
        """Which rows of the data are what."""
        c, scheme = self.c, running.scheme
        c.sequential, c.iterated = scheme.sequential, scheme.iterated
        c.past, c.n_past = self._sizes(running.past), len(running.past)
        for rows, name in ((running.slopes, "slope"), (running.ends, "end")):
            setattr(c, f"{name}_rows", self._sizes([row for row, _ in rows]))
            setattr(c, f"{name}_derivatives", self._sizes([derivative for _, derivative in rows]))
        c.n_slopes, c.n_ends = len(running.slopes), len(running.ends)

    def _describe_prediction(self, running: Prediction) -> None:
        """The data are the signals, the states' rates and the slopes of the free inputs."""
        c, network = self.c, self.network
        c.past, c.n_past = self._sizes([0]), 1
        c.rates_at, c.n_free, c.free_inputs = len(network.signals), len(running.free), self._sizes(running.free)
        last = {unit: place for place, unit in enumerate(network.rounds) if unit not in network.late}
        c.rates_too = self._sizes([last.get(unit) == place for place, unit in enumerate(network.rounds)])
        self._expected = np.flatnonzero(network.drives.any(axis=1))
        c.n_expected, c.expected_inputs = len(self._expected), self._sizes([network.drive_of.tolist().index(k) for k in self._expected])

    def _sizes(self, values: Any) -> int:
        self._alive.append(np.ascontiguousarray(values, np.uintp))
        return self._alive[-1].ctypes.data

    def _doubles(self, values: np.ndarray) -> int:
        self._alive.append(np.ascontiguousarray(values, float))
        return self._alive[-1].ctypes.data

    def _matrix(self, rows: np.ndarray, order: int = 0) -> _Matrix:
        """Columns that are not zero only: with many units a unit's inputs depend on few of the data."""
        columns = np.flatnonzero(rows.any(axis=0))
        padded = np.pad(rows[:, columns], ((0, -len(rows) % BLOCK), (0, 0)))
        blocks = padded.reshape(len(padded) // BLOCK, BLOCK, len(columns)).swapaxes(1, 2)
        return _Matrix(order, len(columns), self._sizes(columns), self._doubles(blocks))

    def _polynomials(self, unit: FmuUnit, matrix: np.ndarray) -> _Matrix:
        """To the coefficients of a unit's inputs, as unit.h has them."""
        rows = matrix.reshape(COEFFICIENTS, len(unit.inputs), -1)
        order = int(np.flatnonzero(rows.any(axis=(1, 2))).max(initial=0))
        scaled = rows if unit.calls.path else derivatives(rows, self.running.step)
        return self._matrix(scaled[: order + 1].reshape((order + 1) * len(unit.inputs), -1), order)

    def _prepare(self) -> None:
        """The units with their matrices, which a new linearisation changes."""
        running = self.running
        if isinstance(running, Prediction):
            self.c.expected = self._matrix(running.expected[self._expected])
        guess, final = (running.guess, running.final) if isinstance(running, Run) else (running.matrices, running.matrices)
        units, first_state = (_Unit * len(self.units))(), 0
        told_first: dict[bytes, int] = {}
        for k, (unit, (_, u, y)) in enumerate(zip(self.units, self.network.part, strict=True)):
            functions = [cast(getattr(unit.calls.fmu.dll, name), c_void_p).value if name else None for name in unit.calls.functions]
            addresses = unit.addresses()
            like = k if addresses["path"] else told_first.setdefault(guess[k].tobytes() + final[k].tobytes(), k)
            if like == k:
                matrices = self._polynomials(unit, guess[k]), self._polynomials(unit, final[k])
                coefficients = unit.calls.path.coefficients if unit.calls.path else self._doubles(np.zeros(COEFFICIENTS * len(unit.inputs)))
            else:
                matrices, coefficients = (units[like].guess, units[like].final), units[like].coefficients
            units[k] = _Unit(instance=unit.calls.fmu.component, version=unit.calls.version, calls=(c_void_p * 8)(*functions), n_inputs=len(unit.inputs),
                             n_outputs=len(unit.outputs), n_states=len(unit.states), order=unit.input_order, first_input=u.start, first_output=y.start,
                             first_state=first_state, like=like, coefficients=coefficients, guess=matrices[0], final=matrices[1], **addresses)  # fmt: skip
            if isinstance(running, Run) and running.scheme.iterated:
                units[k].saved = unit.save()[0].value
            first_state += len(unit.states)
        self._alive.append(units)
        self.c.units = cast(units, c_void_p)

    def begin(self, outputs: np.ndarray) -> None:
        """Where the run begins: the outputs (ny,) as they were read."""
        self.outputs[:] = outputs
        if isinstance(self.running, Run):
            self._data[:] = self.running.data.ravel()
        self.c.time = self.units[0].time if self.units else 0.0

    def steps(self, external: np.ndarray, outputs: np.ndarray, told: np.ndarray) -> None:
        """n steps with inputs from outside (n + 1, nu); writes outputs (n, ny) and what the inputs were told (n, nu).

        Raises SimulationError when an FMU refuses a step or an iteration does not converge.
        """
        self.done = 0
        count = len(external) - 1
        if external.strides[1:] != (8,):
            external = np.ascontiguousarray(external)
        self.c.row = external.strides[0] // 8
        while self.done < count:
            k = self.done
            self.done += self._run(byref(self.c), count - k, external[k:].ctypes.data, outputs[k:].ctypes.data, outputs.strides[0] // 8, told[k:].ctypes.data)
            for unit in self.units:
                unit.time = self.c.time
            if self.c.status:
                self._fail()
            if self.c.renew and isinstance(self.running, Prediction):
                self._renew(external[self.done])

    def _fail(self) -> None:
        c, unit = self.c, self.units[self.c.failed_unit]
        if c.status < 0:
            raise SimulationError("the iteration does not converge")
        if c.status == STOPPED:
            raise SimulationError(f"{unit.name} has ended the step from {c.time:g} s early")
        unit.calls.fail(unit.calls.functions[c.call], c.status)

    def _renew(self, external: np.ndarray) -> None:
        """Linearise anew where the units are, with the inputs (nu,) that come from outside now."""
        assert isinstance(self.running, Prediction)
        self.network.external[:] = external
        self.network.read(self.outputs)
        self.network.settle(self.outputs)
        del self._alive[self._lasting :]
        self.running.renew()
        self._prepare()
