"""Jacobi with every input extrapolated by its value and first three derivatives. Order 4.

It needs no memory, so it has its full order from the first step and after every discontinuity between two steps.
"""

from fmus.cosimulation.polynomials import TAYLOR
from fmus.cosimulation.scheme import Continuation, Scheme

COUPLING = Scheme(
    "taylor",
    "all subsystems at once, inputs extrapolated by three output derivatives",
    order=4,
    source="Arnold, Clauss, Schierz, Arch. Mech. Eng. 60 (2013) 75-94, on output derivatives as inputs",
    before=Continuation(TAYLOR),
)
