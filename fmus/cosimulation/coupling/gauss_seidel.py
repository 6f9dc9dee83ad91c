"""Gauss-Seidel: one subsystem after the other, each with the inputs held at the newest outputs of
the others. Order 1."""

from fmus.cosimulation.polynomials import END, HELD
from fmus.cosimulation.scheme import Continuation, Scheme

COUPLING = Scheme(
    "gauss_seidel",
    "one subsystem after the other, inputs held at the newest outputs",
    order=1,
    source="Kuebler, Schiehlen, Math. Comput. Model. Dyn. Syst. 6 (2000) 93-113",
    before=Continuation(HELD),
    after=Continuation(END),
    sequential=True,
)
