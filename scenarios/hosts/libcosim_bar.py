"""libcosim (the Open Simulation Platform's, through libcosimpy): its fixed-step algorithm on the rider on a bar.

libcosim hands outputs to inputs after all have stepped and sets them at the next step, so the rider's torque that the
bar is told was computed from the motion of a step before: Jacobi with a stale torque. Its times are whole nanoseconds,
and before the first step an observer shows zeros, not what was set. The FMI Library inside logs as an error that the
time has no start value, which FMI 2.0 forbids it to have; what fails raises an exception, so the log is turned off.
"""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from scenarios.hosts.rider_on_a_bar import (
    AT_START,
    CONNECTIONS,
    SAMPLED,
    STRIKE,
    archives,
    mode_errors,
    trajectory_error,
)
from scenarios.hosts.table import main


def run(step: float = 1e-3, duration: float = 1.0) -> dict:
    """Mode and trajectory errors at a step [s]. Raises ModuleNotFoundError without libcosimpy."""
    with TemporaryDirectory() as folder:
        samples = rows(archives(folder), step, round(duration / step))
    return {"fixed_step": {**mode_errors(samples, step), "trajectory_error": trajectory_error(samples, step)}}


def rows(fmus: Mapping[str, Path], step: float, count: int) -> np.ndarray:
    """Samples (count, 5) at the multiples of the step."""
    from libcosimpy.CosimExecution import CosimExecution  # noqa: PLC0415 - an optional package
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level  # noqa: PLC0415 - an optional package
    from libcosimpy.CosimObserver import CosimObserver  # noqa: PLC0415 - an optional package
    from libcosimpy.CosimSlave import CosimLocalSlave  # noqa: PLC0415 - an optional package

    log_output_level(CosimLogLevel.FATAL)
    execution = CosimExecution.from_step_size(round(step * 1e9))
    observer = CosimObserver.create_last_value()
    if not execution.add_observer(observer):
        raise RuntimeError("libcosim takes no observer")
    index, reference = {}, {}
    for name, path in fmus.items():
        index[name] = execution.add_local_slave(CosimLocalSlave(str(path), name))
        reference.update({f"{name}.{v.name.decode()}": v.reference for v in execution.slave_variables(index[name])})
    for source, target, signal in CONNECTIONS:
        execution.connect_real_variables(index[source], reference[f"{source}.{signal}"], index[target], reference[f"{target}.{signal}"])
    execution.real_initial_value(index["vehicle"], reference["vehicle.steer_rate"], STRIKE)
    shown = {name: [reference[s] for s in SAMPLED if s.startswith(name)] for name in fmus}
    sampled = [AT_START]
    for _ in range(count - 1):
        if not execution.step():
            raise RuntimeError("libcosim could not take a step")
        sampled.append([x for name, references in shown.items() for x in observer.last_real_values(index[name], references)])
    return np.array(sampled)


if __name__ == "__main__":
    main(run)
