"""Jacobi with every input continued by its value and first three derivatives. Order 4.

It needs no memory, so it starts at full order and survives whatever jumps between two steps.
"""

from fmus.coupling.polynomials import TAYLOR
from fmus.coupling.scheme import Continuation, Scheme

TAYLOR_SERIES = Scheme(
    "taylor",
    "all units at once, inputs continued by three output derivatives",
    order=4,
    stable="while the step is below about 1 over the fastest eigenvalue of the coupled units",
    source="Arnold, Clauss, Schierz, Arch. Mech. Eng. 60 (2013) 75-94, on output derivatives as inputs",
    before=Continuation(TAYLOR),
)
