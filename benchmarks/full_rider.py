"""What a millisecond of the full rider costs: its compiled FMU against the linear rider's, against the same equations
in NumPy, and against the same six bodies in Exudyn.

The FMUs are led through 4 deg of steer at 2 Hz, set inputs, step 1 ms, read outputs, by one and the same loop in
Python, whose own cost (some microseconds) is in both. NumPy takes the four evaluations of a Runge-Kutta step. Times are
those of the processor, so that what else the machine does is not in them.
"""

import tempfile
import time
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

from fmus.export.build import build
from motofmi.scenarios.hosts.exudyn_full_rider import response
from rider_fmu import riders
from rider_fmu.components.full_rider import on_rig

STEP = 1e-3
INPUTS, OUTPUTS = ("steer_angle", "steer_rate", "frame_rate"), ("handlebar_torque", "frame_torque")


def run(progress, steps: int = 5000, rounds: int = 3) -> dict:
    """Microseconds a step of each, best of some rounds, their ratios, and the compiled rider's real-time factor."""
    full, linear = riders.load("full_mean_2011"), riders.load("mean_2011")
    with tempfile.TemporaryDirectory() as folder:
        built = time.process_time()
        paths = {"full": build(full, folder).path, "linear": build(linear, folder).path}
        built = time.process_time() - built
        fmus = {name: min(fmu_time(path, steps) for _ in progress(range(rounds), name)) for name, path in paths.items()}
    numpy_step = min(numpy_time(full, 30) for _ in progress(range(rounds), "numpy"))
    times = {**fmus, "numpy": numpy_step, "exudyn": exudyn_time(full, 500)}
    ratios = {f"full_fmu_over_{name}": fmus["full"] / t for name, t in times.items() if name != "full" and t}
    return {
        "microseconds_per_step": {n: t and round(1e6 * t, 2) for n, t in times.items()},
        "real_time_factor": STEP / fmus["full"],
        **ratios,
        "build_s": built,
    }


def fmu_time(path: Path, steps: int) -> float:
    """Seconds a step."""
    description = fmpy.read_model_description(str(path))
    folder = fmpy.extract(str(path))
    fmu = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        instanceName="timed",
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    references = {v.name: v.valueReference for v in description.modelVariables}
    inputs, outputs = ([references[n] for n in names] for names in (INPUTS, OUTPUTS))
    phase = 4 * np.pi * STEP * np.arange(steps)
    motion = np.radians(4) * np.column_stack([np.sin(phase), 4 * np.pi * np.cos(phase), 0 * phase])
    motion[:, 1] -= motion[0, 1] * np.exp(-phase)  # the bar starts at rest
    rows = motion.tolist()
    start = time.process_time()
    for k, row in enumerate(rows):
        fmu.setReal(inputs, row)
        fmu.doStep(k * STEP, STEP)
        fmu.getReal(outputs)
    spent = time.process_time() - start
    fmu.terminate()
    fmu.freeInstance()
    return spent / steps


def numpy_time(rider, steps: int) -> float:
    """Seconds of four evaluations of the equations on numbers."""
    state, motion = np.array([0.02, 0.01]), np.array([0.05, 0.3, 0.0])
    start = time.process_time()
    for _ in range(4 * steps):
        rider.derivatives(state, motion)
    return (time.process_time() - start) / steps


def exudyn_time(rider, steps: int) -> float | None:
    """Seconds a step in Exudyn, assembly taken out; None without it."""
    try:
        import exudyn  # noqa: F401, PLC0415 - an optional package
    except ModuleNotFoundError:
        return None

    rig = on_rig(rider)
    spent = []
    for count in (steps, 2 * steps):
        start = time.process_time()
        response(rig, 10.0, 2.0, STEP, count * STEP)
        spent.append(time.process_time() - start)
    return (spent[1] - spent[0]) / steps
