"""fmucontainer (fmu-manipulation-toolbox): both FMUs in one archive that steps them by a table of its own.

The container is an FMU: it runs in any importer, here fmpy. Inside it, the parts exchange the outputs of the
previous step's end, so its torques are delayed as in libcosim. The step size is fixed when the container is made, and
a call of another multiple makes that many steps. Its model description has no InitialUnknowns: validation is off.
"""

import logging
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

from motofmi.scenarios.hosts.rider_on_a_bar import AT_START, CONNECTIONS, SAMPLED, STRIKE, archives, errors
from motofmi.scenarios.hosts.table import main

HOST, PACKAGE = "fmucontainer", "fmu_manipulation_toolbox"


def run(step: float = 1e-3, duration: float = 1.0) -> dict:
    """Mode and trajectory errors at a step [s]. Raises ModuleNotFoundError without fmu-manipulation-toolbox."""
    with TemporaryDirectory() as folder:
        return {"container": errors(rows(archives(folder), step, round(duration / step)), step)}


def container(fmus: Mapping[str, Path], step: float) -> Path:
    """The container of both, beside them."""
    from fmu_manipulation_toolbox.assembly import Assembly, AssemblyNode  # noqa: PLC0415 - an optional package

    logging.getLogger("fmu_manipulation_toolbox").setLevel(logging.ERROR)
    node = AssemblyNode("rider_on_a_bar.fmu", step_size=step, auto_link=False, auto_input=False, auto_output=False)
    folder = fmus["vehicle"].parent
    for source, target, name in CONNECTIONS:
        node.add_link(fmus[source].name, name, fmus[target].name, name)
    for name in SAMPLED:
        part, _, variable = name.partition(".")
        node.add_output(fmus[part].name, variable, name.replace(".", "_"))
    node.add_start_value(fmus["vehicle"].name, "steer_rate", str(STRIKE))
    assembly = Assembly(fmu_directory=folder)
    assembly.root = node
    assembly.make_fmu()
    return folder / "rider_on_a_bar.fmu"


def opened(fmus: Mapping[str, Path], step: float) -> tuple[FMU2Slave, list[int]]:
    """The container in fmpy, initialised, and the references of the samples."""
    path = container(fmus, step)
    description = fmpy.read_model_description(str(path), validate=False)
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=str(fmpy.extract(str(path), str(path.with_suffix("")))),
                    modelIdentifier=description.coSimulation.modelIdentifier, instanceName="container")  # fmt: skip
    references = {v.name: v.valueReference for v in description.modelVariables}
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu, [references[name.replace(".", "_")] for name in SAMPLED]


def rows(fmus: Mapping[str, Path], step: float, count: int) -> np.ndarray:
    """Samples (count, 5) at the multiples of the step, through fmpy."""
    fmu, references = opened(fmus, step)
    found = [AT_START]
    for k in range(count - 1):
        fmu.doStep(k * step, step)
        found.append(fmu.getReal(references))
    fmu.terminate()
    fmu.freeInstance()
    return np.array(found)


SAMPLES = {"fmucontainer in fmpy": rows}

if __name__ == "__main__":
    main(run)
