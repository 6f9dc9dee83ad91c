"""One FMU stepped by itself, with its inputs over time.

Within a step an input is the straight line between its values at both ends; an FMU that takes no input derivatives gets
the constant that is nearest to it in the mean square, the mean of both.
"""

from collections.abc import Mapping
from pathlib import Path
from time import perf_counter

import numpy as np

from fmus.cosimulation.cosimulate import steps
from fmus.cosimulation.cosimulation_run import CosimulationRun
from fmus.cosimulation.network import Network
from fmus.cosimulation.polynomials import COEFFICIENTS
from fmus.cosimulation.profiles import Profile
from fmus.cosimulation.results import Rows, heading
from fmus.cosimulation.subsystems.archive import model_description
from fmus.cosimulation.subsystems.fmu_subsystem import FmuSubsystem
from fmus.cosimulation.subsystems.other_outputs import OtherOutputs
from fmus.support.errors import EndRequestedError
from fmus.support.progress import track

STEP, DURATION = 0.001, 5.0  # s, where neither the caller nor the FMU's default experiment names any
MOST_ROWS = 10_000_000  # of output; more are taken for a typing error and refused
BLOCK = 1000  # rows between two writes


def start_time(path: str | Path) -> float:
    """The start time of the default experiment of an FMU [s]; 0 where it has none. Raises InputError for no FMU."""
    given = float(getattr(model_description(path).defaultExperiment, "startTime", None) or 0.0)
    return given if np.isfinite(given) else 0.0


def simulate(fmu: FmuSubsystem, step: float | None = None, duration: float | None = None,
             times: np.ndarray | None = None, columns: Mapping[str, np.ndarray] | None = None,
             units: Mapping[str, str] | None = None, out: str | Path | None = None) -> CosimulationRun:  # fmt: skip
    """Run an FMU from where it is over `duration` [s], with inputs by name as columns (n,) at ascending times (n,) [s].

    units are those of columns, where they are not those of the inputs. The rows hold inputs and outputs, to the CSV
    file `out` or in the run; numbers, Booleans and enumerations have columns, arrays one for each element. The run ends
    where the FMU asks for it. Its notes state that, and the variables without a column. Without a duration it ends at
    the stop time of the default experiment. Raises InputError for a column that is no input, for a step or a duration
    that is not positive, for inputs that end before the run or begin after it, and for more than MOST_ROWS rows,
    SimulationError when the FMU fails.
    """
    experiment, begin = fmu.description.defaultExperiment, fmu.time
    if duration is None:
        left = float(getattr(experiment, "stopTime", None) or begin + DURATION) - begin
        duration = left if left > 0 else DURATION
    if step is None:
        step = min(float(getattr(experiment, "stepSize", None) or STEP), duration)
    step, count = steps(step, duration, MOST_ROWS)
    network = Network({fmu.name: fmu}, {})
    profile = Profile.over_time(network, np.zeros(1) if times is None else times, columns or {}, units)
    names = [*network.inputs, *network.outputs]
    others = OtherOutputs(fmu)
    notes = (*profile.uncovered(begin, begin + duration), *others.notes)
    titles = [heading(name, fmu.unit_of(name.partition(".")[2])) for name in names]
    titles += [
        heading(f"{fmu.name}.{name}", fmu.unit_of(variable))
        for name, variable in zip(others.names, others.variables, strict=True)
    ]
    rows = Rows(["time [s]", *titles], out, count + 1)
    coefficients = np.zeros((COEFFICIENTS, len(fmu.inputs)))
    inputs = profile.at(np.array([begin]))[0]
    block = [np.concatenate([[begin], inputs, fmu.exchange(inputs), others.read()])]
    began = perf_counter()
    try:
        for k in track(range(count), "simulation", count):
            following = profile.at(np.array([begin + (k + 1) * step]))[0]
            rise = following - inputs
            coefficients[0], coefficients[1] = (inputs, rise) if fmu.input_order else (inputs + rise / 2, 0.0)
            try:
                fmu.step(coefficients, step)
            except EndRequestedError as end:
                early = f", before the duration of {duration:g} s" if end.time < begin + (1 - 1e-9) * duration else ""
                notes = (f"{end}{early}", *notes)
                count = k
                if end.time > begin + (k + 1e-9) * step:  # part of a step, or a whole one
                    count += 1
                    reached = profile.at(np.array([end.time]))[0]
                    block.append(np.concatenate([[end.time], reached, fmu.present_outputs(), others.read()]))
                break
            inputs = following
            block.append(np.concatenate([[begin + (k + 1) * step], inputs, fmu.exchange(inputs), others.read()]))
            if len(block) >= BLOCK:
                rows.write(np.array(block))
                block = []
    finally:
        if block:
            rows.write(np.array(block))
        rows.close()
    rate = count / (perf_counter() - began)
    return CosimulationRun(step, "none", rows.columns, rows.kept, rows.path, rate, None, [], count, step, step,
                           notes=notes)  # fmt: skip
