"""Jacobi with every input continued along the line through the last two values. Order 2."""

from fmus.coupling.polynomials import LINEAR
from fmus.coupling.scheme import Continuation, Scheme

JACOBI_LINEAR = Scheme(
    "jacobi_linear",
    "all units at once, inputs continued as lines",
    order=2,
    stable=(0.0207, 0.0156),
    source="Busch, ZAMM 96 (2016) 1061-1081",
    before=Continuation(LINEAR),
)
