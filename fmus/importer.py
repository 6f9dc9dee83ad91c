"""Any co-simulation FMU, FMI 2.0 or 3.0, as a unit that a coupling can step and that can be linearised."""

from fmus.archive import model_description
from fmus.fmu_instance import FmuInstance
from fmus.fmu_linear import linearise
from fmus.linear import StateSpace


class FmuUnit(FmuInstance):
    """One instance of an FMU: see `fmus.fmu_instance` and `fmus.fmu_linear`."""

    def linearised(self) -> StateSpace:
        return linearise(self)


__all__ = ["FmuUnit", "model_description"]
