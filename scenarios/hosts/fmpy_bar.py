"""fmpy's simulator, its SSP runner, and a loop of four calls through fmpy: results with the same two FMUs.

`simulate_fmu` sets the inputs, steps, and records without setting inputs again: an output that follows an input at
once (the arms' torque) is recorded with the inputs of the step's start, one step late. The SSP runner connects in the
same way and stamps its rows with the step's start though they hold for its end; `rows_of_ssp` puts that right. It gives
an input without a connection that of the connector before; `write_ssp` names connected inputs only. In the loop, inputs
are set before outputs are read, and the outputs are of the moment.
"""

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet

from fmus import linearise
from fmus.cosimulation.ssp import write_ssp
from motofmi.scenarios.hosts.rider_on_a_bar import AT_START, CONNECTIONS, SAMPLED, STRIKE, archives, errors, parts
from motofmi.scenarios.hosts.table import main

HOST, PACKAGE = "fmpy", "fmpy"
OMEGA = 20.0  # rad/s, of the prescribed steer angle
SETTLED = 2.0  # s, after which what was at the start has decayed to 1e-16


def run(step: float = 1e-3, duration: float = 1.0) -> dict:
    """What lags in simulate_fmu; mode and trajectory errors of SSP runner and loop at a step [s]."""
    with TemporaryDirectory() as folder:
        fmus = archives(folder)
        count = round(duration / step)
        found: dict = {"simulate_fmu": lag_of_simulate_fmu(fmus["device"], step)}
        found["ssp"] = errors(rows_of_ssp_runner(fmus, step, count), step)
        found["loop"] = errors(rows_of_loop(fmus, step, count), step)
    return found


def lag_of_simulate_fmu(rider: Path, step: float) -> dict[str, float]:
    """The delay of the torque that simulate_fmu records for a sinusoidal steer angle, compared with the exact response.

    The arms' torque is k_a (theta - delta) + c_a (theta' - s): with the recorded torso, the recorded torque gives the
    time to which delta and s belong.
    """
    times = np.arange(round((SETTLED + 2.0) / step) + 1) * step
    dtype = [(n, np.float64) for n in ("time", "steer_angle", "steer_rate", "frame_rate")]
    motion = np.array(
        list(zip(times, np.sin(OMEGA * times), OMEGA * np.cos(OMEGA * times), 0 * times, strict=True)), dtype
    )
    result = fmpy.simulate_fmu(str(rider), stop_time=times[-1], output_interval=step, input=motion,
                               output=["handlebar_torque", "torso_angle", "torso_rate"])  # fmt: skip
    result = result[result["time"] > SETTLED]
    waves = np.exp(1j * OMEGA * result["time"])
    component = parts()["device"]
    stiffness, damping = component.values["arm_stiffness"], component.values["arm_damping"]
    of_steer = stiffness * result["torso_angle"] + damping * result["torso_rate"] - result["handlebar_torque"]
    cosine, sine = np.linalg.lstsq(np.column_stack([waves.real, waves.imag]), of_steer, rcond=None)[0]
    space = linearise(component)
    angle, rate = (
        space.frequency_response(np.array(OMEGA), "handlebar_torque", n) for n in ("steer_angle", "steer_rate")
    )
    exact = ((angle + 1j * OMEGA * rate) * waves).imag
    return {"lag_in_steps": float(np.angle((stiffness + 1j * OMEGA * damping) / (sine + 1j * cosine)) / (OMEGA * step)),
            "torque_error": float(np.abs(result["handlebar_torque"] - exact).max() / np.abs(exact).max())}  # fmt: skip


def rows_of_ssp_runner(fmus: Mapping[str, Path], step: float, count: int) -> np.ndarray:
    """Samples (count, 5) of the SSP runner, from an archive beside the FMUs."""
    wiring = {f"{target}.{n}": [f"{source}.{n}"] for source, target, n in CONNECTIONS}
    return rows_of_ssp(write_ssp(fmus["vehicle"].with_name("wired.ssp"), fmus, wiring), step, count)


def rows_of_ssp(path: Path, step: float, count: int) -> np.ndarray:
    """Samples (count, 5); the runner's first row, stamped 0, is that of the first step's end."""
    struck = ParameterSet(name="struck", parameters=[Parameter(name="vehicle.steer_rate", value=STRIKE)])
    result = simulate_ssp(str(path), stop_time=(count - 1.5) * step, step_size=step, parameter_set=struck)
    return np.vstack([AT_START, np.column_stack([result[name] for name in SAMPLED])])


def rows_of_loop(fmus: Mapping[str, Path], step: float, count: int) -> np.ndarray:
    """Samples (count, 5) of the loop: motion out of the bar, into the rider, torque out of the rider,
    into the bar, step."""
    (bar, bar_references), (rider, rider_references) = (opened(fmus[n]) for n in ("vehicle", "device"))
    motion = ("steer_angle", "steer_rate")
    bar_motion, rider_motion = ([r[n] for n in motion] for r in (bar_references, rider_references))
    outputs = [rider_references[n] for n in ("torso_angle", "torso_rate", "handlebar_torque")]
    bar.setReal([bar_references["steer_rate"]], [STRIKE])
    rows = []
    for fmu in (bar, rider):
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
    for k in range(count):
        angle_and_rate = bar.getReal(bar_motion)
        rider.setReal(rider_motion, angle_and_rate)
        values = rider.getReal(outputs)
        bar.setReal([bar_references["handlebar_torque"]], values[-1:])
        rows.append(angle_and_rate + values)
        for fmu in (bar, rider):
            fmu.doStep(k * step, step)
    for fmu in (bar, rider):
        fmu.terminate()
        fmu.freeInstance()
    return np.array(rows)


def opened(path: Path) -> tuple[FMU2Slave, dict[str, int]]:
    """An instance before its initialisation, and the value references by name."""
    description = fmpy.read_model_description(str(path))
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=str(fmpy.extract(str(path), str(path.with_suffix("")))),
                    modelIdentifier=description.coSimulation.modelIdentifier, instanceName=path.stem)  # fmt: skip
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    return fmu, {v.name: v.valueReference for v in description.modelVariables}


SAMPLES = {"fmpy loop": rows_of_loop, "fmpy SSP runner": rows_of_ssp_runner}

if __name__ == "__main__":
    main(run)
