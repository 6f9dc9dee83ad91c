"""The touring motorcycle of 2020: processor time of modes and of steady turning at 60 speeds, and of its FMU against
Exudyn's time integration of the same motion with the same step.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path
from time import process_time

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

import motofmi as mf
from fmus.export.build import build
from motofmi.scenarios.hosts.exudyn_motorcycle import SMALL, motion
from vehicle_fmu import motorcycles

SPEEDS = np.linspace(10.0, 60.0, 60)
SPEED, STEP, DURATION = 30.0, 5e-4, 1.0


def run(progress) -> dict:
    """Seconds for 60 speeds; seconds of both integrations of 1 s, their ratio, and the largest difference of roll and
    steer as shares of their largest values.
    """
    mf.trim("tum_2020", speed=SPEED, lean=0.0)  # imports and tables that are made once
    found = {"modes_60_speeds_s": _seconds(lambda: mf.modes("tum_2020", speed=SPEEDS))}
    for lean in progress((0.0, 30.0), "steady turning at 60 speeds"):
        found[f"trim_60_speeds_at_{lean:g}_deg_s"] = _seconds(
            lambda lean=lean: [mf.trim("tum_2020", speed=v, lean=lean) for v in SPEEDS]
        )
    return {**found, **_against_exudyn()}


def _against_exudyn() -> dict[str, float]:
    motorcycle = motorcycles.load("tum_2020")
    with tempfile.TemporaryDirectory() as folder:
        fmu = _Fmu(build(motorcycle, folder).path)
        begin = process_time()
        ours = fmu.motion()
        own_s = process_time() - begin
    begin = process_time()
    theirs = motion(motorcycle, SPEED, STEP, DURATION, {"steer_rate": SMALL})
    exudyn_s = process_time() - begin
    columns = [motorcycle.states.index(name) for name in _Fmu.OUTPUTS]
    difference = np.abs(ours - theirs[:, columns]).max(axis=0) / np.abs(ours).max(axis=0)
    return {"fmu_s": own_s, "exudyn_s": exudyn_s, "exudyn_per_fmu": exudyn_s / own_s,
            "fmu_times_real_time": DURATION / own_s, "largest_difference": float(difference.max())}  # fmt: skip


class _Fmu:
    """The motorcycle's FMU 2.0, started with a steer rate."""

    OUTPUTS = ("roll_angle", "steer_angle")

    def __init__(self, path: Path):
        description = fmpy.read_model_description(str(path))
        place = {v.name: v.valueReference for v in description.modelVariables}
        self.outputs = [place[name] for name in self.OUTPUTS]
        self.fmu = FMU2Slave(guid=description.guid, unzipDirectory=fmpy.extract(str(path)), instanceName="timed",
                             modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.setReal([place["speed"], place["steer_rate"]], [SPEED, SMALL])
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def motion(self) -> np.ndarray:
        """The outputs (n, 2) at all steps."""
        rows = [self.fmu.getReal(self.outputs)]
        for k in range(round(DURATION / STEP)):
            self.fmu.doStep(k * STEP, STEP)
            rows.append(self.fmu.getReal(self.outputs))
        return np.array(rows)


def _seconds(call: Callable[[], object]) -> float:
    begin = process_time()
    call()
    return process_time() - begin
