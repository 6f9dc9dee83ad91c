"""Couplings of subsystems by name, the cheapest first: every module of this folder that has a COUPLING.

A new coupling is a new file here:

    COUPLING = Scheme("held", "all subsystems at once, inputs held", order=1, source="...", before=Continuation(HELD))
"""

from fmus.cosimulation.coupling_protocol import Coupling
from fmus.support.errors import unknown
from fmus.support.modules import modules_in

_FOUND: list[Coupling] = [module.COUPLING for module in modules_in(__name__)]
COUPLINGS: dict[str, Coupling] = {c.name: c for c in sorted(_FOUND, key=lambda c: (c.cost, c.name))}


def coupling(name: str) -> Coupling:
    """The coupling of that name. Raises InputError with the valid names."""
    if name not in COUPLINGS:
        raise unknown("coupling", name, COUPLINGS)
    return COUPLINGS[name]


__all__ = ["COUPLINGS", "Coupling", "coupling"]
