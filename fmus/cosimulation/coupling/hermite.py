"""One pass, one subsystem after the other: torque extrapolated as a parabola, then the angle interpolated as a
Hermite cubic. Order 3.

The port has an angle and its rate, so after the vehicle's step the angle is the cubic through both ends with both
rates, and the rate is its derivative. No state is restored.
"""

from fmus.cosimulation.polynomials import HERMITE, PARABOLA, QUADRATIC
from fmus.cosimulation.scheme import Continuation, Scheme

COUPLING = Scheme(
    "hermite",
    "one subsystem after the other, torque as a parabola, then angle as a Hermite cubic",
    order=3,
    source="Hermite interpolation of the motion: Schweizer, Lu, Li, ZAMM 96 (2016) 821-844",
    before=Continuation(QUADRATIC),
    after=Continuation(PARABOLA, angle=HERMITE, rate=None),
    sequential=True,
)
