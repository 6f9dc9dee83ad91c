"""What a step of an FMU costs: the compiled one against the same arithmetic behind the same calls, and against pythonfmu.

All loops set the inputs, step 1 ms and read the outputs. Each time is the best of some rounds in which the candidates
take turns, so that the ratios hold on a machine that does other things as well.
"""

import ctypes
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from scipy.linalg import expm

from fmus.declaration.component import Component
from fmus.equations.sympy_form import symbolic
from fmus.export.build import build, source_contents
from fmus.export.compilers import FLAGS, host_compiler
from fmus.export.interface import Interface
from fmus.linear_analysis.linearisation import linearise
from rider_fmu import riders
from vehicle_fmu import motorcycles

LOOP = Path(__file__).parent / "c" / "loop.c"
STEP = 1e-3
ROUNDS = 7


class Loaded:
    """A started FMU 2.0 with the addresses of its three functions and preallocated arrays."""

    def __init__(self, path: Path):
        description = fmpy.read_model_description(str(path))
        begin = time.perf_counter()
        folder = fmpy.extract(str(path))
        self.unzip_time = time.perf_counter() - begin
        self.fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName="timed",
                             modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
        begin = time.perf_counter()
        self.fmu.instantiate()
        self.instantiate_time = time.perf_counter() - begin
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        variables = description.modelVariables
        # The speed keeps its value: with another in each step the exact step needs other matrices each time.
        self.inputs = np.array(
            [v.valueReference for v in variables if v.causality == "input" and v.name != "speed"], np.uint32
        )
        self.outputs = np.array([v.valueReference for v in variables if v.causality == "output"], np.uint32)
        self.instance = self.fmu.component
        self.functions = [
            ctypes.cast(getattr(self.fmu.dll, f), ctypes.c_void_p) for f in ("fmi2SetReal", "fmi2DoStep", "fmi2GetReal")
        ]


def compiled_loop(component: Component, folder: Path) -> ctypes.CDLL:
    """benchmarks/c/loop.c with the component's model.c."""
    for name, data in source_contents(Interface(component), 2).items():
        (folder / name.rpartition("/")[2]).write_bytes(data)
    library = folder / "loop.so"
    flags = [f for f in FLAGS if f != "-fvisibility=hidden"]
    subprocess.run(
        [*(host_compiler() or ("cc",)), *flags, "-fPIC", "-I", str(folder), "-o", str(library), str(LOOP), "-lm"],
        check=True,
    )
    return ctypes.CDLL(str(library))


class Bare(ctypes.Structure):
    """The instance of the bare arithmetic."""

    _fields_ = [(n, ctypes.c_void_p) for n in ("z", "columns")]


def bare_instance(component: Component, library: ctypes.CDLL) -> tuple[Bare, list[np.ndarray]]:
    """The matrix of the exact step and the values at their starts."""
    interface = Interface(component)
    model, nx, nu = linearise(component), len(component.states), len(component.inputs)
    wide = np.zeros((nx + nu, nx + nu))
    wide[:nx, :nx], wide[:nx, nx:] = model.A, model.B
    wide[:, nx:] *= [n not in (symbolic(component).scheduling or ()) for n in component.inputs]
    both = expm(STEP * wide)[:nx]
    arrays = [np.zeros(len(interface.variables) + 1000), np.ascontiguousarray(np.column_stack([both, np.zeros(nx)]).T)]
    arrays[0][: len(interface.variables)] = [v.start for v in interface.variables]
    bare = Bare(*(a.ctypes.data for a in arrays))
    library.bare_parameters(ctypes.byref(bare))
    return bare, arrays


def in_c(library: ctypes.CDLL, functions: list, instance, like: Loaded, steps: int) -> Callable[[], float]:
    """Seconds per step of the loop in C over the inputs and outputs of a loaded FMU."""
    values = np.zeros(len(like.inputs) + len(like.outputs))
    arrays = [ctypes.c_void_p(a.ctypes.data) for a in (like.inputs, like.outputs, values)]
    clock = [0.0]

    def timed() -> float:
        begin = time.perf_counter()
        library.loop(*functions, instance, arrays[0], len(like.inputs), arrays[1], len(like.outputs), arrays[2],
                     ctypes.c_double(STEP), ctypes.c_double(clock[0]), ctypes.c_long(steps))  # fmt: skip
        clock[0] += steps * STEP
        return (time.perf_counter() - begin) / steps

    assert len(values) == len(like.inputs) + len(like.outputs)
    return timed


def in_python(loaded: Loaded, steps: int) -> Callable[[], float]:
    """Seconds per step of the loop in Python, through ctypes with arrays made once."""
    dll, c = loaded.fmu.dll, ctypes.c_void_p(loaded.instance)
    values = [np.zeros(len(loaded.inputs)), np.zeros(len(loaded.outputs))]
    given, read = ((c, ctypes.c_void_p(r.ctypes.data), ctypes.c_size_t(len(r)), ctypes.c_void_p(v.ctypes.data))
                   for r, v in zip((loaded.inputs, loaded.outputs), values, strict=True))  # fmt: skip
    access = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p)
    advance = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int)
    set_real, get_real, do_step = (
        access(("fmi2SetReal", dll)),
        access(("fmi2GetReal", dll)),
        advance(("fmi2DoStep", dll)),
    )
    clock = [0.0]

    def timed() -> float:
        assert all(v.ctypes.data for v in values)  # the arrays live as long as the loop
        now, begin = clock[0], time.perf_counter()
        for _ in range(steps):
            set_real(*given)
            do_step(c, now, STEP, 1)
            get_real(*read)
            now += STEP
        clock[0] = now
        return (time.perf_counter() - begin) / steps

    return timed


def measured(component: Component, folder: Path, steps: int, rounds: int = ROUNDS) -> dict:
    """Seconds per step of each candidate, their ratios, and the sizes and times around the stepping."""
    library = compiled_loop(component, folder)
    built = {b: build(component, folder, backend=b) for b in ("compiled", "python")}
    fmus = {b: (Loaded(built[b].path), Loaded(built[b].path)) for b in built}  # one for each loop
    bare, kept = bare_instance(component, library)
    like = fmus["compiled"][0]
    plain = {
        kind: [ctypes.cast(getattr(library, f"{kind}_{f}"), ctypes.c_void_p) for f in ("set", "step", "get")]
        for kind in ("bare", "empty")
    }
    python_steps = max(steps // 300, 100)
    loops = {
        "compiled, C loop": in_c(library, like.functions, ctypes.c_void_p(like.instance), like, steps),
        "bare arithmetic, C loop": in_c(library, plain["bare"], ctypes.byref(bare), like, steps),
        "empty calls, C loop": in_c(library, plain["empty"], None, like, steps),
        "pythonfmu, C loop": in_c(
            library,
            fmus["python"][0].functions,
            ctypes.c_void_p(fmus["python"][0].instance),
            fmus["python"][0],
            python_steps,
        ),
        "compiled, ctypes loop": in_python(fmus["compiled"][1], max(steps // 30, 100)),
        "pythonfmu, ctypes loop": in_python(fmus["python"][1], python_steps),
    }
    best = dict.fromkeys(loops, np.inf)
    for _ in range(rounds):
        best = {name: min(best[name], loop()) for name, loop in loops.items()}
    assert all(np.all(np.isfinite(a)) for a in kept)
    for pair in fmus.values():
        for each in pair:
            each.fmu.freeInstance()
    return {
        "nanoseconds_per_step": {name: round(1e9 * t, 1) for name, t in best.items()},
        "compiled_over_bare": best["compiled, C loop"] / best["bare arithmetic, C loop"],
        "pythonfmu_over_compiled_in_c": best["pythonfmu, C loop"] / best["compiled, C loop"],
        "pythonfmu_over_compiled_through_ctypes": best["pythonfmu, ctypes loop"] / best["compiled, ctypes loop"],
        "archive_bytes": {b: built[b].path.stat().st_size for b in built},
        "unzip_milliseconds": {b: round(1e3 * fmus[b][1].unzip_time, 2) for b in built},
        "instantiate_milliseconds": {b: round(1e3 * fmus[b][1].instantiate_time, 3) for b in built},
    }


def run(progress: Callable, steps: int = 300_000) -> dict:
    """The rider and the motorcycle at constant speed."""
    found = {}
    for component in progress([riders.load("mean_2011"), motorcycles.load("sharp_1971")], "steps of FMUs"):
        with tempfile.TemporaryDirectory() as folder:
            found[component.name] = measured(component, Path(folder), steps)
    return found
