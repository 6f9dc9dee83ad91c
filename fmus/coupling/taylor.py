"""Jacobi with every input continued by its value and first three derivatives. Order 4.

It needs no memory, so it starts at full order and survives whatever jumps between two steps.
"""

from fmus.coupling.polynomials import TAYLOR
from fmus.coupling.scheme import Continuation, Scheme

TAYLOR_SERIES = Scheme(
    "taylor",
    "all units at once, inputs continued by three output derivatives",
    order=4,
    stable=(0.0481, 0.0412),
    source="Arnold, Clauss, Schierz, Arch. Mech. Eng. 60 (2013) 75-94, on output derivatives as inputs",
    before=Continuation(TAYLOR),
)
