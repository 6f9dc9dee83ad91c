"""Iterated with rollback, every signal the Hermite cubic through values and rates at both ends. Order 4.

The rates are the FMUs' output derivatives; an angle's rate is a signal of its own.
"""

from fmus.cosimulation.polynomials import HELD, HERMITE
from fmus.cosimulation.scheme import Continuation, Scheme

COUPLING = Scheme(
    "implicit_hermite",
    "iterated until inputs are Hermite cubics; needs saved states and output derivatives",
    order=4,
    source="Schweizer, Lu, Li, ZAMM 96 (2016) 821-844",
    before=Continuation(HELD),
    after=Continuation(HERMITE, angle=HERMITE),
    iterated=True,
)
