"""The loop over the steps: compiled where the units are FMUs and a C compiler is there, else in Python."""

from fmus.coupling import Network
from fmus.coupling.interface_jacobian import Prediction
from fmus.coupling.scheme import Run
from fmus.errors import MissingToolError
from fmus.master.compiled import CompiledMaster, can_compile
from fmus.master.interpreted import InterpretedMaster

Master = CompiledMaster | InterpretedMaster


def master(network: Network, running: Run | Prediction) -> Master:
    """The fastest loop that these units and this machine allow."""
    if can_compile(network):
        try:
            return CompiledMaster(network, running)
        except MissingToolError:
            pass
    return InterpretedMaster(network, running)


__all__ = ["CompiledMaster", "InterpretedMaster", "Master", "master"]
