"""Iterated with rollback: the step is repeated until every input is the line between what was and what comes out. Order 2."""

from fmus.coupling.polynomials import HELD, LINE
from fmus.coupling.scheme import Continuation, Scheme

ITERATED = Scheme(
    "iterated",
    "repeated until inputs are lines between both ends; needs saved states",
    order=2,
    stable=(0.0256, 0.0246),
    source="Kuebler, Schiehlen, Math. Comput. Model. Dyn. Syst. 6 (2000) 93-113",
    before=Continuation(HELD),
    after=Continuation(LINE),
    iterated=True,
)
