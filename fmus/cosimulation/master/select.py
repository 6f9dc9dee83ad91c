"""The loop over the steps: compiled for FMUs and the couplings that it knows, where a C compiler is
there; else in Python."""

from fmus.cosimulation.coupling.interface_jacobian import InterfaceJacobianState
from fmus.cosimulation.coupling_protocol import RunningCoupling
from fmus.cosimulation.master.compiled import CompiledMaster, can_compile
from fmus.cosimulation.master.interpreted import InterpretedMaster
from fmus.cosimulation.network import Network
from fmus.cosimulation.scheme import CouplingState
from fmus.support.errors import MissingToolError

Master = CompiledMaster | InterpretedMaster


def master(network: Network, state: RunningCoupling) -> Master:
    """The fastest loop that these subsystems and this machine allow."""
    if can_compile(network) and isinstance(state, CouplingState | InterfaceJacobianState):
        try:
            return CompiledMaster(network, state)
        except MissingToolError:
            pass
    return InterpretedMaster(network, state)


__all__ = ["CompiledMaster", "InterpretedMaster", "Master", "master"]
