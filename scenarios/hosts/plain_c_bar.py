"""A host of sixty lines of C that needs nothing but the unzipped archive: examples/rider_on_a_bar.c.

It holds no torque over a step: the torque's slope (fmi2GetRealOutputDerivatives) enters the bar's motion, and the
rider is told that motion as polynomials (fmi2SetRealInputDerivatives). So it is of second order where hosts that
exchange values alone are of the first.
"""

import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
import numpy as np

from fmus import compilers
from fmus.errors import InputError
from scenarios.hosts.rider_on_a_bar import STEER_INERTIA, archives, errors
from scenarios.hosts.table import main

SOURCE = Path(__file__).parents[2] / "examples" / "rider_on_a_bar.c"


def run(step: float = 1e-3, duration: float = 1.0) -> dict:
    """Mode and trajectory errors at a step [s]. Raises MissingToolError without a C compiler."""
    return {"plain_c": errors(rows(step, duration)[:, 1:], step)}


def rows(step: float, duration: float) -> np.ndarray:
    """Time and samples (n, 6) that the compiled host prints."""
    if not SOURCE.is_file():
        raise InputError(f"{SOURCE} is missing: the plain C host is part of the source tree, run this from a checkout")
    (compiler,) = compilers.commands(compilers.host(), native=True)
    with TemporaryDirectory() as folder:
        unzipped = fmpy.extract(str(archives(folder)["device"]), f"{folder}/rider")
        host = f"{folder}/rider_on_a_bar"
        subprocess.run([*compiler, "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", f"-I{unzipped}/sources", str(SOURCE), "-o", host, "-ldl"],
                       check=True)  # fmt: skip
        printed = subprocess.run([host, str(unzipped), repr(STEER_INERTIA), repr(step), repr(duration)], check=True, capture_output=True, text=True)
    return np.loadtxt(printed.stdout.splitlines(), delimiter=",", skiprows=1)


if __name__ == "__main__":
    main(run)
