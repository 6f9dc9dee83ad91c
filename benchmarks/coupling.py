"""Couplings and masters on the same FMUs with the same steps: steps per second, errors of modes and of the trajectory.

The case is the mean rider on a bar of 0.6 kg.m2, struck. Ours are all couplings of `fmus.cosimulation.coupling`; the
others are the loops of other people's tools, as far as they are installed, and the plainest loop in C. Set-up is
excluded: a rate, in steps per second of processor time, so that it is the same on a busy machine,
is the difference of two runs of different length. Also: what 2 to 200 riders on one bar cost.
"""

import ctypes
import subprocess
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from fmus.cosimulation.cosimulate import cosimulate
from fmus.cosimulation.coupling import COUPLINGS
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.export.compilers import FLAGS, host_compiler
from fmus.support.errors import InputError
from motofmi.scenarios.hosts import container_bar, hosts
from motofmi.scenarios.hosts.rider_on_a_bar import SAMPLED, STRIKE, archives, mode_errors, trajectory_error

SOURCES = Path(__file__).parent / "c"
STEPS = (1e-3, 1e-2)
COUNT = 20_000  # steps of one measurement of a rate; the bare loop makes more, so as to take as long
DEVICES = (2, 20, 200)
ROUNDS = 15
Rows = Callable[[Mapping[str, Path], float, int], np.ndarray]


def opened(fmus: Mapping[str, Path], devices: int = 1) -> dict[str, FmuSubsystem]:
    """The bar, struck, and its riders."""
    subsystems = {"vehicle": FmuSubsystem(fmus["vehicle"], "vehicle", {"steer_rate": STRIKE})}
    names = ["device"] if devices == 1 else [f"device_{k}" for k in range(devices)]
    return subsystems | {name: FmuSubsystem(fmus["device"], name) for name in names}


def closed(subsystems: Mapping[str, FmuSubsystem]) -> None:
    for subsystem in subsystems.values():
        subsystem.close()


def ours(fmus: Mapping[str, Path], name: str, step: float, count: int) -> np.ndarray:
    """Samples (count, 5) of one of our couplings."""
    subsystems = opened(fmus)
    try:
        found = cosimulate(subsystems, step, (count - 1) * step, name)
    finally:
        closed(subsystems)
    return np.column_stack([found[signal] for signal in SAMPLED])


def our_seconds(fmus: Mapping[str, Path], name: str, step: float, count: int) -> float:
    """Processor time of one run of ours, set-up included."""
    subsystems = opened(fmus)
    try:
        began = time.thread_time()
        cosimulate(subsystems, step, count * step, name)
        return time.thread_time() - began
    finally:
        closed(subsystems)


def rates(fmus: Mapping[str, Path], step: float, count: int, rounds: int) -> dict[str, float]:
    """Steps per second of processor time of the loops in C and of all couplings, taking turns: from the shortest times
    of `count` and of three times as many."""
    best = {"bare_c_loop": 0.0, "fmucontainer_in_c": container_rate(fmus, step, count, rounds)}
    shortest = {name: [np.inf, np.inf] for name in COUPLINGS}
    for _ in range(rounds):
        best["bare_c_loop"] = max(best["bare_c_loop"], bare_rate(fmus, step, 5 * count))
        for name, times in shortest.items():
            for k, steps in enumerate((count, 3 * count)):
                times[k] = min(times[k], our_seconds(fmus, name, step, steps))
    return best | {name: 2 * count / max(longer - shorter, 1e-9) for name, (shorter, longer) in shortest.items()}


def errors(samples: np.ndarray, step: float) -> dict[str, Any]:
    """Errors of a host's modes and of its trajectory, the latter infinite where it diverges."""
    if not np.isfinite(samples).all() or np.abs(samples).max() > 1e6:
        return {"trajectory_error": None, "diverges": True}
    modes = {mode: asdict(error) for mode, error in mode_errors(samples, step).items()}
    return {**modes, "trajectory_error": trajectory_error(step * np.arange(len(samples)), samples[:, 0])}


# Samples of every host that has the case of a rider on a bar.
PEERS: dict[str, Rows] = {
    name: rows for host in hosts().values() for name, rows in getattr(host, "SAMPLES", {}).items()
}


def peer(rows: Rows, fmus: Mapping[str, Path], step: float, samples: int, count: int) -> dict[str, Any] | None:
    """Errors over samples, and the rate, of another tool; None where it is not installed. Its set-up is in neither."""
    try:
        found = errors(rows(fmus, step, samples), step)
    except ModuleNotFoundError:
        return None
    shortest = {count: np.inf, 3 * count: np.inf}
    for _ in range(3):
        for steps in shortest:
            began = time.process_time()
            rows(fmus, step, steps)
            shortest[steps] = min(shortest[steps], time.process_time() - began)
    longer = shortest[3 * count] - shortest[count]
    return {**found, "steps_per_second": 2 * count / longer if longer > 0 else None}


def in_c(source: str) -> ctypes.CDLL:
    """A loop of benchmarks/c, compiled with the FMUs' own flags."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder, "loop.so")
        subprocess.run(
            [
                *(host_compiler() or ("cc",)),
                *(f for f in FLAGS if f != "-fvisibility=hidden"),
                "-fPIC",
                "-o",
                str(library),
                str(SOURCES / source),
            ],
            check=True,
        )
        return ctypes.CDLL(str(library))


def container_rate(fmus: Mapping[str, Path], step: float, count: int, rounds: int) -> float:
    """Steps per second of fmucontainer's archive in a loop in C, the best of rounds; 0 where the tool is not
    installed."""
    try:
        fmu, references = container_bar.opened(fmus, step)
    except ModuleNotFoundError:
        return 0.0
    loop, wanted, values = in_c("host.c").host, np.array(references, np.uint32), np.zeros(len(references))
    functions = [ctypes.cast(getattr(fmu.dll, f), ctypes.c_void_p) for f in ("fmi2DoStep", "fmi2GetReal")]
    best = 0.0
    for k in range(rounds):
        began = time.thread_time()
        loop(ctypes.c_void_p(fmu.component), *functions, ctypes.c_void_p(wanted.ctypes.data), ctypes.c_size_t(len(wanted)),
             ctypes.c_void_p(values.ctypes.data), ctypes.c_double(step), ctypes.c_long(k * count), ctypes.c_long((k + 1) * count))  # fmt: skip
        best = max(best, count / (time.thread_time() - began))
    fmu.terminate()
    fmu.freeInstance()
    return best


class _Subsystem(ctypes.Structure):
    _fields_ = [(n, ctypes.c_void_p) for n in ("instance", "set", "get", "step", "inputs", "outputs")] + [
        (n, ctypes.c_size_t) for n in ("n_inputs", "n_outputs")
    ]


def bare_rate(fmus: Mapping[str, Path], step: float, count: int) -> float:
    """Steps per second of Jacobi in the plainest C loop over the same binaries."""
    motion, torques = ("steer_angle", "steer_rate", "frame_rate"), ("handlebar_torque", "frame_torque")
    subsystems, arrays = opened(fmus), []
    loop = in_c("jacobi.c").jacobi
    both = []
    for name, received, returned in (("vehicle", torques, motion), ("device", motion, torques)):
        subsystem = subsystems[name]
        references = [
            np.array([subsystem.variables[n].valueReference for n in names], np.uint32) for names in (received, returned)
        ]
        arrays += references
        functions = [
            ctypes.cast(getattr(subsystem.calls.fmu.dll, f), ctypes.c_void_p)
            for f in ("fmi2SetReal", "fmi2GetReal", "fmi2DoStep")
        ]
        both.append(
            _Subsystem(
                subsystem.calls.fmu.component, *functions, *(r.ctypes.data for r in references), *map(len, references)
            )
        )
    values = np.zeros(3), np.zeros(2)
    began = time.thread_time()
    loop(
        *(ctypes.byref(u) for u in both),
        *(ctypes.c_void_p(v.ctypes.data) for v in values),
        ctypes.c_double(step),
        ctypes.c_long(count),
    )
    rate = count / (time.thread_time() - began)
    assert np.isfinite(values[0]).all() and arrays
    closed(subsystems)
    return rate


def scaling(fmus: Mapping[str, Path], count: int, numbers: Sequence[int]) -> dict[str, float]:
    """Microseconds per step and rider for several numbers of riders on one bar, Jacobi."""
    found = {}
    for devices in numbers:
        subsystems = opened(fmus, devices)
        rate = cosimulate(subsystems, 1e-4, count * 1e-4, "jacobi").steps_per_second
        found[str(devices)] = 1e6 / rate / devices
        closed(subsystems)
    return found


def run(
    progress: Callable, count: int = COUNT, samples: int = 500, rounds: int = ROUNDS, devices: Sequence[int] = DEVICES
) -> dict[str, Any]:
    """All couplings and peers at 1 and 10 ms; count steps for a measurement of a rate, samples for the errors."""
    short = f"{STEPS[0]:g}"
    with tempfile.TemporaryDirectory() as folder:
        fmus = archives(folder)
        rate = rates(fmus, STEPS[0], count, rounds)
        found: dict[str, Any] = {
            name: {"steps_per_second": rate[name]} for name in ("bare_c_loop", "fmucontainer_in_c")
        }
        found |= {"ours": {}, "peers": {}}
        for name in progress(COUPLINGS, "couplings"):
            found["ours"][name] = {f"{step:g}": _our_errors(fmus, name, step, samples) for step in STEPS}
            found["ours"][name]["steps_per_second"] = rate[name]
        for name, rows in progress(PEERS.items(), "other tools"):
            found["peers"][name] = {f"{step:g}": peer(rows, fmus, step, samples, count // 5) for step in STEPS}
        found["microseconds_per_rider_and_step"] = scaling(fmus, count, devices)
        found["most_accurate_over_bare"] = rate["interface_jacobian"] / rate["bare_c_loop"]
        fastest = max((p[short]["steps_per_second"] or 0.0 for p in found["peers"].values() if p[short]), default=None)
        found["most_accurate_over_fastest_peer"] = rate["interface_jacobian"] / fastest if fastest else None
    return found


def _our_errors(fmus: Mapping[str, Path], name: str, step: float, samples: int) -> dict[str, Any]:
    try:
        return errors(ours(fmus, name, step, samples), step)
    except (InputError, RuntimeError):  # it diverges and says so
        return {"trajectory_error": None, "diverges": True}
