"""The loop over the steps as a small C library, called once for many steps: see master.c.

The library is compiled once for a machine and kept in the cache. The matrices, orders and wires are those that
the coupling made in Python; here they become addresses. Only a new linearisation needs Python within a run.
"""

import tempfile
from ctypes import CDLL, Structure, byref, c_char_p, c_double, c_int, c_size_t, c_void_p, cast
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from fmus import compilers
from fmus.build import cache_folder, content_key
from fmus.coupling import Network
from fmus.coupling.interface_jacobian import MISSED, Prediction
from fmus.coupling.polynomials import COEFFICIENTS
from fmus.coupling.scheme import CONVERGED, PASSES, Run
from fmus.errors import SimulationError
from fmus.files import write_beside
from fmus.fmi_calls import Calls2
from fmus.importer import FmuUnit

SOURCE = "master.c"
FUNCTIONS = {"set": "fmi2SetReal", "get": "fmi2GetReal", "step": "fmi2DoStep", "set_slopes": "fmi2SetRealInputDerivatives",
             "get_slopes": "fmi2GetRealOutputDerivatives", "save": "fmi2GetFMUstate", "restore": "fmi2SetFMUstate"}  # fmt: skip


def _fields(**groups: Any) -> list[tuple[str, Any]]:
    return [(name, kind) for kind, names in groups.values() for name in names.split()]


class _Unit(Structure):
    _fields_ = _fields(
        a=(c_void_p, "instance saved " + " ".join(FUNCTIONS)),
        b=(c_size_t, "n_inputs n_outputs n_states order first_input first_output first_state"),
        c=(c_void_p, "inputs outputs rates slope_inputs slope_orders output_orders"),
        d=(c_size_t, "guess_order final_order"),
        e=(c_void_p, "guess_rows guess_columns final_rows final_columns guess final"),
    )


class _Master(Structure):
    _fields_ = _fields(
        a=(c_size_t, "n_units n_inputs n_outputs n_signals n_data"), b=(c_void_p, "units where wire_start wires rounds late"),
        c=(c_size_t, "n_rounds n_late"), d=(c_void_p, "past slope_rows slope_derivatives end_rows end_derivatives"),
        e=(c_size_t, "n_past n_slopes n_ends"), f=(c_void_p, "free_inputs"), g=(c_size_t, "rates_at n_free"), h=(c_void_p, "expected"),
        i=(c_double, "missed converged step_size time"), j=(c_int, "sequential iterated passes"),
        k=(c_void_p, "data now told coefficients slopes scratch"), l=(c_size_t, "failed_unit"), m=(c_int, "status renew"), n=(c_char_p, "function"),
    )  # fmt: skip


@cache
def library() -> CDLL:
    """The compiled loop. Raises MissingToolError when there is no C compiler."""
    source = files("fmus").joinpath("master", SOURCE).read_bytes()
    host = compilers.host()
    command = compilers.commands(host, native=True)[0]
    path = cache_folder() / f"master-{content_key({SOURCE: source}, ' '.join(command), compilers.version(command))[:32]}{host.suffix}"
    if not path.is_file():
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, SOURCE).write_bytes(source)
            binary = compilers.compile_library(host, True, Path(folder), [SOURCE], "master")[0]
        write_beside(path, lambda beside: beside.write_bytes(binary))
    found = CDLL(str(path))
    found.master_run.restype = c_size_t
    found.master_run.argtypes = [c_void_p, c_size_t, c_void_p, c_void_p, c_size_t, c_void_p]
    return found


def can_compile(network: Network) -> bool:
    """Whether all units are FMI 2.0 instances."""
    return all(isinstance(unit, FmuUnit) and isinstance(unit.calls, Calls2) for unit, _, _ in network.part)


class CompiledMaster:
    """Runs a prepared coupling. `done` counts the steps of the last call that were made.

    Raises MissingToolError when there is no C compiler.
    """

    chunk = 5000  # steps between two looks from outside

    def __init__(self, network: Network, running: Run | Prediction):
        self.network, self.running, self.done = network, running, 0
        self.units = [unit for unit, _, _ in network.part if isinstance(unit, FmuUnit)]
        self._run = library().master_run
        self._alive: list[Any] = []  # what the structures point to
        n_data = running.data.size if isinstance(running, Run) else running.expected.shape[1]
        wires = [np.flatnonzero(row) for row in network.wires]
        self._data, self.outputs = np.zeros(n_data), np.zeros(len(network.outputs))
        largest = max((len(u.inputs) for u in self.units), default=0)
        self.c = _Master(
            len(self.units), len(network.inputs), len(network.outputs), len(network.signals), n_data, None, self._sizes(network.where),
            self._sizes(np.cumsum([0, *map(len, wires)])), self._sizes(np.concatenate([np.zeros(0), *wires])), self._sizes(network.rounds), self._sizes(network.late),
            len(network.rounds), len(network.late),
            missed=MISSED, converged=CONVERGED, step_size=running.step, passes=PASSES, data=self._data.ctypes.data, now=self.outputs.ctypes.data,
            told=self._doubles(np.zeros(len(network.inputs))), coefficients=self._doubles(np.zeros(4 * largest + 1)),
            slopes=self._doubles(np.zeros(3 * len(network.outputs) + 1)), scratch=self._doubles(np.zeros(8 * len(network.inputs) + n_data + 1)),
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
        c = self.c
        c.past, c.n_past = self._sizes([0]), 1
        c.rates_at, c.n_free, c.free_inputs = len(self.network.signals), len(running.free), self._sizes(running.free)

    def _sizes(self, values: Any) -> int:
        self._alive.append(np.ascontiguousarray(values, np.uintp))
        return self._alive[-1].ctypes.data

    def _doubles(self, values: np.ndarray) -> int:
        self._alive.append(np.ascontiguousarray(values, float))
        return self._alive[-1].ctypes.data

    def _sparse(self, name: str, matrix: np.ndarray) -> dict[str, int]:
        """The entries that are not zero: with many units a unit's inputs depend on few of the data."""
        found = csr_matrix(matrix)
        highest = int(found.nonzero()[0].max(initial=0)) // (len(matrix) // COEFFICIENTS) if found.nnz else 0
        return {f"{name}_order": highest, f"{name}_rows": self._sizes(found.indptr), f"{name}_columns": self._sizes(found.indices), name: self._doubles(found.data)}

    def _prepare(self) -> None:
        """The units with their matrices, which a new linearisation changes."""
        running = self.running
        if isinstance(running, Prediction):
            self.c.expected = self._doubles(running.expected)
        guess, final = (running.guess, running.final) if isinstance(running, Run) else (running.matrices, running.matrices)
        units, first_state = (_Unit * len(self.units))(), 0
        for k, (unit, (_, u, y)) in enumerate(zip(self.units, self.network.part, strict=True)):
            functions = {field: cast(getattr(unit.calls.fmu.dll, name), c_void_p).value for field, name in FUNCTIONS.items()}
            units[k] = _Unit(instance=unit.calls.fmu.component, n_inputs=len(unit.inputs), n_outputs=len(unit.outputs), n_states=len(unit.states),
                             order=unit.input_order, first_input=u.start, first_output=y.start, first_state=first_state,
                             **self._sparse("guess", guess[k]), **self._sparse("final", final[k]), **functions, **unit.addresses())  # fmt: skip
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
        count, external = len(external) - 1, np.ascontiguousarray(external)
        while self.done < count:
            k = self.done
            self.done += self._run(byref(self.c), count - k, external[k:].ctypes.data, outputs[k:].ctypes.data, outputs.strides[0] // 8, told[k:].ctypes.data)
            for unit in self.units:
                unit.time = self.c.time
            if self.c.status < 0:
                raise SimulationError(f"the {self.c.function.decode()} does not converge")
            if self.c.status:
                self.units[self.c.failed_unit].calls.fail(self.c.function.decode(), self.c.status)
            if self.c.renew and isinstance(self.running, Prediction):
                del self._alive[self._lasting :]
                self.running.renew()
                self._prepare()

