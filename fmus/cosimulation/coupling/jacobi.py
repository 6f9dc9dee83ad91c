"""Jacobi: all subsystems step at once with the inputs held at the last outputs. Order 1."""

from fmus.cosimulation.polynomials import HELD
from fmus.cosimulation.scheme import Continuation, Scheme

COUPLING = Scheme(
    "jacobi",
    "all subsystems at once, inputs held",
    order=1,
    source="Kuebler, Schiehlen, Math. Comput. Model. Dyn. Syst. 6 (2000) 93-113",
    before=Continuation(HELD),
)
