"""libcosim (the Open Simulation Platform's, through libcosimpy) on the rider on a bar: fixed steps, and ECCO's own.

libcosim hands outputs to inputs after all have stepped and sets them at the next step, so the rider's torque at the
bar was computed from the motion of the previous step: Jacobi with a delayed torque. Its times are whole nanoseconds,
and before the first step an observer shows zeros, not what was set. ECCO (Sadjina, Pedersen, Engineering with Computers
36, 2020) chooses steps by the power that a bond loses; libcosimpy's default rates of change, 0.01 to 0.2, let a step
only shrink, so others are set here. The FMI Library inside logs as an error that the time has no start value, which FMI
2.0 forbids it to have; what fails is noticed here by what is returned, so the log is turned off.
"""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from motofmi.scenarios.hosts.rider_on_a_bar import (
    AT_START,
    CONNECTIONS,
    SAMPLED,
    STRIKE,
    archives,
    errors,
    trajectory_error,
)
from motofmi.scenarios.hosts.table import main

HOST, PACKAGE = "libcosim", "libcosimpy"
BOND = ("vehicle.steer_rate", "vehicle.handlebar_torque", "device.handlebar_torque", "device.steer_rate")
SLOWEST, FASTEST = 0.2, 1.5  # ECCO's rates of change of the step


def run(step: float = 1e-3, duration: float = 1.0, tolerance: float = 1e-4) -> dict:
    """Mode and trajectory errors at a fixed step [s]; steps and trajectory error with ECCO at a tolerance.

    Raises ModuleNotFoundError without libcosimpy.
    """
    with TemporaryDirectory() as folder:
        fmus = archives(folder)
        _, samples = rows(Wired(fmus, fixed(step)), duration)
        times, chosen = rows(Wired(fmus, *ecco(step, tolerance)), duration)
    return {"fixed_step": errors(samples, step),
            "ecco": {"steps": len(times) - 1, "smallest_step": np.diff(times).min(),
                     "largest_step": np.diff(times).max(),
                     "trajectory_error": trajectory_error(times, chosen[:, 0])}}  # fmt: skip


def fixed(step: float) -> Any:
    """An execution with a fixed step [s]."""
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415 - an optional package

    return CosimExecution.from_step_size(round(step * 1e9))


def ecco(step: float, tolerance: float) -> tuple[Any, Any]:
    """An execution whose steps ECCO chooses, from a hundredth to ten times a step [s], and its algorithm."""
    from libcosimpy.CosimAlgorithm import CosimAlgorithm, EccoParams  # noqa: PLC0415 - an optional package
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415 - an optional package

    algorithm = CosimAlgorithm.create_ecco_algorithm(
        EccoParams(step_size=step, min_step_size=step / 100, max_step_size=step * 10, abs_tolerance=tolerance,
                   rel_tolerance=tolerance, min_change_rate=SLOWEST, max_change_rate=FASTEST))  # fmt: skip
    return CosimExecution.from_algorithm(algorithm), algorithm


class Wired:
    """Bar and rider in an execution, wired, with the bar struck; observed at every step."""

    def __init__(self, fmus: Mapping[str, Path], execution: Any, algorithm: Any = None):
        from libcosimpy.CosimLogging import CosimLogLevel, log_output_level  # noqa: PLC0415 - an optional package
        from libcosimpy.CosimObserver import CosimObserver  # noqa: PLC0415 - an optional package
        from libcosimpy.CosimSlave import CosimLocalSlave  # noqa: PLC0415 - an optional package

        log_output_level(CosimLogLevel.FATAL)
        self.execution, self._algorithm, self._observer = execution, algorithm, CosimObserver.create_last_value()
        execution.add_observer(self._observer)
        self._index = {name: execution.add_local_slave(CosimLocalSlave(str(path), name)) for name, path in fmus.items()}
        self._reference = {
            f"{name}.{v.name.decode()}": v.reference
            for name, index in self._index.items()
            for v in execution.slave_variables(index)
        }
        for source, target, signal in CONNECTIONS:
            execution.connect_real_variables(*self._of(f"{source}.{signal}"), *self._of(f"{target}.{signal}"))
        if algorithm is not None:
            (one, rate, torque), (other, answer, motion) = (
                (*self._of(a), self._reference[b]) for a, b in (BOND[:2], BOND[2:])
            )
            algorithm.add_power_bond(one, rate, torque, other, answer, motion)
        execution.real_initial_value(*self._of("vehicle.steer_rate"), STRIKE)

    def _of(self, variable: str) -> tuple[int, int]:
        """Index of the slave and reference of the variable."""
        return self._index[variable.partition(".")[0]], self._reference[variable]

    def sample(self) -> list[float]:
        """The values (5,) that the observer saw last."""
        return [self._observer.last_real_values(index, [reference])[0] for index, reference in map(self._of, SAMPLED)]


def rows(wired: Wired, duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) [s] and samples (n, 5) until the duration [s]."""
    times, sampled = [0], [AT_START]
    while times[-1] < round(duration * 1e9):
        if not wired.execution.step():
            raise RuntimeError(f"libcosim stopped at {times[-1] / 1e9} s")
        times.append(wired.execution.status().current_time)
        sampled.append(wired.sample())
    return np.array(times) / 1e9, np.array(sampled)


def fixed_steps(fmus: Mapping[str, Path], step: float, count: int) -> np.ndarray:
    """Samples (count, 5) at the multiples of a step [s]."""
    return rows(Wired(fmus, fixed(step)), (count - 1) * step)[1]


SAMPLES = {"libcosim": fixed_steps}

if __name__ == "__main__":
    main(run)
