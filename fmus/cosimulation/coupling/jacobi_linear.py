"""Jacobi with every input extrapolated along the line through the last two values. Order 2."""

from fmus.cosimulation.polynomials import LINEAR
from fmus.cosimulation.scheme import Continuation, Scheme

COUPLING = Scheme(
    "jacobi_linear",
    "all subsystems at once, inputs extrapolated as lines",
    order=2,
    source="Busch, ZAMM 96 (2016) 1061-1081",
    before=Continuation(LINEAR),
)
