"""Jacobi: all units step at once with the inputs held at what was answered last. Order 1."""

from fmus.coupling.polynomials import HELD
from fmus.coupling.scheme import Continuation, Scheme

JACOBI = Scheme(
    "jacobi",
    "all units at once, inputs held",
    order=1,
    stable="while the step is well below damping over stiffness at the port: a held torque is a late damper",
    source="Kuebler, Schiehlen, Math. Comput. Model. Dyn. Syst. 6 (2000) 93-113",
    before=Continuation(HELD),
)
