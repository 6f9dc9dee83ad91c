"""One pass, one unit after the other: torques continued as parabolas, then the angle reached as a Hermite cubic. Order 3.

The port carries an angle and its rate, so over a step that has been made the angle is known as the cubic through
both ends with both rates, and the rate as its derivative. No unit ever goes back.
"""

from fmus.coupling.polynomials import HERMITE, PARABOLA, QUADRATIC
from fmus.coupling.scheme import Continuation, Scheme

HERMITE_PASS = Scheme(
    "hermite",
    "one unit after the other, torque as a parabola, then the angle as a Hermite cubic",
    order=3,
    stable=(0.01695, 0.01219),
    source="Hermite interpolation of the motion: Schweizer, Lu, Li, ZAMM 96 (2016) 821-844",
    before=Continuation(QUADRATIC),
    after=Continuation(PARABOLA, angle=HERMITE, rate=None),
    sequential=True,
)
