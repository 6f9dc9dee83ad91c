"""CoFMPy: its three couplings on the rider on a bar.

Results are stamped with the step's start though they hold for its end; inputs are zero until something has stepped. The
order in which Gauss-Seidel takes a loop's members is that of a set of names, which changes from run to run with
Python's hash seed: it is set here before the first step. A default step size in an archive ends CoFMPy 1.0.0 in a
TypeError (it compares the texts), so copies without one are made. CoFMPy pins releases of fmpy and pythonfmu older than
motofmi needs, and runs well with newer ones, so it is installed without its dependencies:

    pip install --no-deps cofmupy && pip install confluent-kafka networkx pandas plotly
"""

import re
from collections.abc import Mapping
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from zipfile import ZipFile

import numpy as np

from motofmi.scenarios.hosts.rider_on_a_bar import AT_START, CONNECTIONS, SAMPLED, STRIKE, archives, errors
from motofmi.scenarios.hosts.table import main

HOST, PACKAGE = "CoFMPy", "cofmupy"
COUPLINGS = {"jacobi": ("jacobi", False), "gauss_seidel": ("gauss_seidel", False), "iterated": ("gauss_seidel", True)}


def run(step: float = 1e-3, duration: float = 1.0) -> dict:
    """Mode and trajectory errors of each coupling at a step [s]. Raises ModuleNotFoundError without CoFMPy."""
    found = {}
    with TemporaryDirectory() as folder:
        fmus = {name: without_step_size(path) for name, path in archives(folder).items()}
        for name, (method, iterative) in COUPLINGS.items():
            found[name] = errors(rows(fmus, step, round(duration / step), method, iterative), step)
    return found


def without_step_size(path: Path) -> Path:
    """A copy of the archive, beside it, whose DefaultExperiment names no step size."""
    copy = path.with_stem(f"{path.stem}_for_cofmpy")
    with ZipFile(path) as given, ZipFile(copy, "w") as made:
        for name in given.namelist():
            data = given.read(name)
            made.writestr(
                name,
                re.sub(rb'(<DefaultExperiment[^>]*?) stepSize="[^"]*"', rb"\1", data)
                if name == "modelDescription.xml"
                else data,
            )
    return copy


def rows(fmus: Mapping[str, Path], step: float, count: int, method: str, iterative: bool) -> np.ndarray:
    """Samples (count, 5) at the multiples of the step; the bar steps before the rider."""
    from cofmupy import Coordinator  # noqa: PLC0415 - an optional package

    start = {"vehicle": {"steer_rate": STRIKE}, "device": {}}
    configuration = {
        "fmus": [{"id": name, "path": str(path), "initialization": start[name]} for name, path in fmus.items()],
        "connections": [{"source": {"id": source, "variable": n, "type": "fmu"},
                         "target": {"id": target, "variable": n, "type": "fmu"}}
                        for source, target, n in CONNECTIONS],
        "cosim_method": method,
        "iterative": iterative,
    }  # fmt: skip
    coordinator = Coordinator()
    with redirect_stdout(StringIO()):
        coordinator.start(configuration)
    coordinator.master.sequence_order = [["vehicle", "device"]]
    for _ in range(count - 1):
        coordinator.do_step(step)
    results = coordinator.get_results()
    return np.vstack([AT_START, np.column_stack([results[tuple(name.split("."))] for name in SAMPLED])])


def jacobi(fmus: Mapping[str, Path], step: float, count: int) -> np.ndarray:
    """Samples (count, 5) of its Jacobi coupling."""
    return rows({name: without_step_size(path) for name, path in fmus.items()}, step, count, "jacobi", False)


SAMPLES = {"CoFMPy": jacobi}

if __name__ == "__main__":
    main(run)
