"""Iterated with rollback, every signal the Hermite cubic through values and rates at both ends. Order 4.

The rates are the FMUs' output derivatives; an angle's rate is a signal of its own.
"""

from fmus.coupling.polynomials import HELD, HERMITE
from fmus.coupling.scheme import Continuation, Scheme

IMPLICIT_HERMITE = Scheme(
    "implicit_hermite",
    "repeated until inputs are Hermite cubics; needs saved states and output derivatives",
    order=4,
    stable=(0.0244, 0.0209),
    source="Schweizer, Lu, Li, ZAMM 96 (2016) 821-844",
    before=Continuation(HELD),
    after=Continuation(HERMITE, angle=HERMITE),
    iterated=True,
)
