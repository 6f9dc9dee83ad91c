"""A host of sixty lines of C that needs nothing but the unzipped archive: rider_on_a_bar.c beside this module.

The torque is not held over a step: its slope (fmi2GetRealOutputDerivatives) enters the bar's motion, which the
rider's FMU gets as polynomials (fmi2SetRealInputDerivatives). The error is of second order, that of hosts that
exchange values alone of first order.
"""

import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
import numpy as np

from fmus.export import compilers
from motofmi.scenarios.hosts.rider_on_a_bar import STEER_INERTIA, archives, errors
from motofmi.scenarios.hosts.table import main

HOST, PACKAGE = "plain C", "fmpy"
SOURCE = Path(__file__).with_name("rider_on_a_bar.c")
HEADERS = Path(fmpy.__file__).parent / "c-code"  # of the standard


def run(step: float = 1e-3, duration: float = 1.0) -> dict:
    """Mode and trajectory errors at a step [s]. Raises MissingToolError without a C compiler."""
    return {"plain_c": errors(rows(step, duration)[:, 1:], step)}


def rows(step: float, duration: float) -> np.ndarray:
    """Time and samples (n, 6) that the compiled host prints."""
    (compiler,) = compilers.commands(compilers.host(), native=True)
    with TemporaryDirectory() as folder:
        unzipped = fmpy.extract(str(archives(folder)["device"]), f"{folder}/rider")
        host = f"{folder}/rider_on_a_bar"
        subprocess.run([*compiler, "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", f"-I{HEADERS}", str(SOURCE), "-o", host, "-ldl"],
                       check=True)  # fmt: skip
        printed = subprocess.run(
            [host, str(unzipped), repr(STEER_INERTIA), repr(step), repr(duration)],
            check=True,
            capture_output=True,
            text=True,
        )
    return np.loadtxt(printed.stdout.splitlines(), delimiter=",", skiprows=1)


if __name__ == "__main__":
    main(run)
