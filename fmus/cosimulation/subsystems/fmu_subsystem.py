"""Any co-simulation FMU, FMI 2.0 or 3.0, as a subsystem: stepped by a coupling, and linearised."""

from fmus.cosimulation.subsystems.archive import model_description
from fmus.cosimulation.subsystems.fmu_instance import FmuInstance
from fmus.cosimulation.subsystems.linearised_fmu import linearise
from fmus.linear_analysis.linearisation import StateSpace


class FmuSubsystem(FmuInstance):
    """One instance of an FMU: see `fmus.cosimulation.subsystems.fmu_instance` and
    `fmus.cosimulation.subsystems.linearised_fmu`."""

    def linearised(self) -> StateSpace:
        return linearise(self)


__all__ = ["FmuSubsystem", "model_description"]
