"""Couplings of units by name, the cheapest first."""

from fmus.coupling.gauss_seidel import GAUSS_SEIDEL
from fmus.coupling.hermite import HERMITE_PASS
from fmus.coupling.implicit_hermite import IMPLICIT_HERMITE
from fmus.coupling.interface_jacobian import INTERFACE_JACOBIAN, InterfaceJacobian
from fmus.coupling.iterated import ITERATED
from fmus.coupling.jacobi import JACOBI
from fmus.coupling.jacobi_linear import JACOBI_LINEAR
from fmus.coupling.jacobi_quadratic import JACOBI_QUADRATIC
from fmus.coupling.network import Network
from fmus.coupling.scheme import Scheme
from fmus.coupling.taylor import TAYLOR_SERIES
from fmus.coupling.units import LinearUnit, Unit
from fmus.errors import unknown

Coupling = Scheme | InterfaceJacobian

ALL: tuple[Coupling, ...] = (JACOBI, GAUSS_SEIDEL, JACOBI_LINEAR, JACOBI_QUADRATIC, HERMITE_PASS, TAYLOR_SERIES,
                             INTERFACE_JACOBIAN, ITERATED, IMPLICIT_HERMITE)  # fmt: skip
COUPLINGS: dict[str, Coupling] = {c.name: c for c in ALL}


def coupling(name: str) -> Coupling:
    """The coupling of that name. Raises InputError with the valid names."""
    if name not in COUPLINGS:
        raise unknown("coupling", name, COUPLINGS)
    return COUPLINGS[name]


__all__ = ["COUPLINGS", "Coupling", "LinearUnit", "Network", "Unit", "coupling"]
