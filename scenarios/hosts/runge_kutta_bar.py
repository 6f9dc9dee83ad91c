"""A Runge-Kutta solver of fourth order in Python: the bar's equation of motion, with the rider's FMU asked in every stage.

    I s' = T_h,   delta' = s

The FMU steps between the solver's steps only (see `motofmi.scenarios.hosts.device`).
"""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from motofmi.scenarios.hosts.device import Device
from motofmi.scenarios.hosts.rider_on_a_bar import STEER_INERTIA, STRIKE, archives, errors
from motofmi.scenarios.hosts.table import main

HOST, PACKAGE = "Runge-Kutta", "fmpy"


def run(step: float = 1e-3, duration: float = 1.0) -> dict:
    """Mode and trajectory errors at a step [s]."""
    with TemporaryDirectory() as folder:
        return {"runge_kutta": errors(rows(archives(folder), step, round(duration / step)), step)}


def rows(fmus: Mapping[str, Path], step: float, count: int) -> np.ndarray:
    """Samples (count, 5) at the multiples of the step."""
    device = Device(fmus["device"], fmus["device"].with_suffix(""))
    bar, found = np.array([0.0, STRIKE]), []

    def rates(time: float, bar: np.ndarray) -> np.ndarray:
        return np.array([bar[1], device.torques(time, np.array([*bar, 0.0]))[0] / STEER_INERTIA])

    for k in range(count):
        t = k * step
        device.meet(t, np.array([*bar, 0.0]))
        found.append([*bar, *device.get("torso_angle", "torso_rate", "handlebar_torque")])
        first = rates(t, bar)
        second = rates(t + step / 2, bar + step / 2 * first)
        third = rates(t + step / 2, bar + step / 2 * second)
        bar = bar + step / 6 * (first + 2 * second + 2 * third + rates(t + step, bar + step * third))
    device.close()
    return np.array(found)


if __name__ == "__main__":
    main(run)
