"""Iterated with rollback: the step is repeated until every input is linear between its values at both ends. Order 2."""

from fmus.cosimulation.polynomials import HELD, LINE
from fmus.cosimulation.scheme import Continuation, Scheme

COUPLING = Scheme(
    "iterated",
    "iterated until inputs are lines between both ends; needs saved states",
    order=2,
    source="Kuebler, Schiehlen, Math. Comput. Model. Dyn. Syst. 6 (2000) 93-113",
    before=Continuation(HELD),
    after=Continuation(LINE),
    iterated=True,
)
