"""Gauss-Seidel: one unit after the other, each with the inputs held at what those before it have reached. Order 1."""

from math import inf

from fmus.coupling.polynomials import END, HELD
from fmus.coupling.scheme import Continuation, Scheme

GAUSS_SEIDEL = Scheme(
    "gauss_seidel",
    "one unit after the other, inputs held at what the former have reached",
    order=1,
    stable=(0.00887, inf),
    source="Kuebler, Schiehlen, Math. Comput. Model. Dyn. Syst. 6 (2000) 93-113",
    before=Continuation(HELD),
    after=Continuation(END),
    sequential=True,
)
