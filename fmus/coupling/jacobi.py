"""Jacobi: all units step at once with the inputs held at what was answered last. Order 1."""

from fmus.coupling.polynomials import HELD
from fmus.coupling.scheme import Continuation, Scheme

JACOBI = Scheme(
    "jacobi",
    "all units at once, inputs held",
    order=1,
    stable=(0.0365, 0.0263),
    source="Kuebler, Schiehlen, Math. Comput. Model. Dyn. Syst. 6 (2000) 93-113",
    before=Continuation(HELD),
)
