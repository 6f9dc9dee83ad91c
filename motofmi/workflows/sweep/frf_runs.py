"""Runs that compute the transfer functions of devices at their port over frequency; several devices add up."""

from typing import Any

import numpy as np

from fmus.declaration.component import Component
from fmus.interfaces.handlebar import TORQUES
from fmus.linear_analysis.linearisation import linearise
from fmus.support.errors import InputError
from motofmi.studies.axes import numbers
from motofmi.studies.runs import Column, Computed, Coordinate, Result
from motofmi.workflows.device import FREQUENCY, at_the_port
from motofmi.workflows.sweep.system_runs import SystemRuns
from motofmi.workflows.sweep.systems import Systems

POINT = 10e-6  # s of processor time for a device at one frequency


class FrfRuns(SystemRuns):
    """`handlebar_torque` and `frame_torque` per steer angle [N.m/rad], complex, over `frequency`."""

    OPTIONS = ("frequency",)
    VEHICLE = False

    @classmethod
    def checked(cls, study: Any, systems: Systems) -> dict[str, Any]:
        if study.speed is not None:
            raise InputError("transfer functions of devices have no speed: leave it out, or choose kind = modes")
        given = study.options.get("frequency", FREQUENCY)
        frequency = (
            numbers(given, "frequency", "Hz") if isinstance(given, str) else np.atleast_1d(np.asarray(given, float))
        )
        if not (np.isfinite(frequency).all() and (frequency > 0).all() and (np.diff(frequency) > 0).all()):
            raise InputError("frequencies must be finite, positive and ascending [Hz]")
        for device in range(len(systems.devices)):
            held = systems.parts(0, device)
            for part in held.values():
                if not isinstance(part, Component) or not set(TORQUES) <= set(part.outputs):
                    raise InputError(f"{part.name} has no handlebar torque: a study of transfer functions takes riders "
                                     "and dampers at the handlebar")  # fmt: skip
            if not held:
                raise InputError("device 'none' has no transfer functions (valid: rider:NAME, damper:VALUE)")
        return {"frequency": frequency}

    def describe(self) -> None:
        frequency = self.options["frequency"]
        self.results = {n: Result(("frequency",), frequency.shape, "complex128", "N.m/rad", "torque per steer angle")
                        for n in TORQUES}  # fmt: skip
        self.extra = {"frequency": Coordinate("frequency", frequency, "Hz", "frequency")}
        self.values: dict[str, Column] = {}

    def cost(self) -> float:
        return POINT * len(self.options["frequency"])

    def of_system(self, vehicle: int, device: int, indices: np.ndarray) -> Computed:
        omega = 2 * np.pi * self.options["frequency"][:, None]
        values = self.systems.values(indices)
        arrays = {n: np.zeros((len(indices), len(omega)), complex) for n in TORQUES}
        for name, part in self.systems.parts(vehicle, device).items():
            own = {n: column for (owner, n), column in values.items() if owner == name}
            assert isinstance(part, Component)
            self.systems.within_bounds(part, own)
            for output, response in at_the_port(linearise(part, **own), omega).items():
                arrays[output] += np.broadcast_to(response, (len(omega), len(indices))).T
        return Computed(arrays, {})
