"""A device's FMU at the handlebar of a simulator without FMI: stepped once in a step, evaluated any number of times.

Between two communication points of simulator and FMU the torques follow the motion u = (delta, s, w) at once,

    T(t) = T_k + (dT/dt)_k (t - t_k) + (dT/du)_k (u(t) - u_k)

with the slope at held motion (fmi2GetRealOutputDerivatives) and the interface Jacobian (fmi2GetDirectionalDerivative).
Evaluating that steps nothing, so a solver may call it in every stage and iteration. At the next communication point the
FMU steps over the time since the last one, with linear motion. Both errors are of the second order in the step; a
torque that is held (`follows=False`) is of the first.
"""

from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

from fmus.interfaces.handlebar import MOTION, TORQUES


class Device:
    """One instance of a rider's or damper's FMU, from time 0 and rest."""

    def __init__(self, path: str | Path, folder: str | Path, follows: bool = True):
        """The archive at `path` is extracted into `folder`."""
        description = fmpy.read_model_description(str(path))
        references = {v.name: v.valueReference for v in description.modelVariables}
        self._inputs, self._outputs = [references[n] for n in MOTION], [references[n] for n in TORQUES]
        self._references = references
        self._fmu = FMU2Slave(guid=description.guid, unzipDirectory=str(fmpy.extract(str(path), str(folder))),
                              modelIdentifier=description.coSimulation.modelIdentifier,
                              instanceName=description.modelName)  # fmt: skip
        self._fmu.instantiate()
        self._fmu.setupExperiment(startTime=0.0)
        self._fmu.enterInitializationMode()
        self._fmu.exitInitializationMode()
        self._follows = follows
        self._time, self._motion = 0.0, np.zeros(len(MOTION))
        self.meet(self._time, self._motion)

    def meet(self, time: float, motion: np.ndarray) -> None:
        """The simulator has reached a time [s] with steer angle, steer rate and frame rate (3,), SI: the FMU
        steps to that time."""
        step = time - self._time
        if step > 0:
            if self._follows:
                self._fmu.setRealInputDerivatives(self._inputs, [1, 1, 1], (motion - self._motion) / step)
            self._fmu.doStep(self._time, step)
        self._fmu.setReal(self._inputs, motion)
        self._time, self._motion = time, motion
        self._torques = np.array(self._fmu.getReal(self._outputs))
        if self._follows:
            self._fmu.setRealInputDerivatives(
                self._inputs, [1, 1, 1], [0.0, 0.0, 0.0]
            )  # those of the last step still count
            self._slopes = np.array(self._fmu.getRealOutputDerivatives(self._outputs, [1, 1]))
            self._jacobian = np.column_stack(
                [self._fmu.getDirectionalDerivative(self._outputs, [n], [1.0]) for n in self._inputs]
            )

    def has(self, name: str) -> bool:
        """Whether the FMU has a variable of that name."""
        return name in self._references

    def torques(self, time: float, motion: np.ndarray) -> np.ndarray:
        """Torques (2,) on handlebar and frame [N.m] at a time [s] since the last communication point, with the
        motion (3,) of that time."""
        if not self._follows:
            return self._torques
        return self._torques + self._slopes * (time - self._time) + self._jacobian @ (motion - self._motion)

    def get(self, *names: str) -> list[float]:
        """Variables of the FMU at the last communication point."""
        return self._fmu.getReal([self._references[n] for n in names])

    def close(self) -> None:
        self._fmu.terminate()
        self._fmu.freeInstance()
