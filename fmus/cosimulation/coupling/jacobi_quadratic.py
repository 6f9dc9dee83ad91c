"""Jacobi with every input extrapolated along the parabola through the last three values. Order 3.

An angle whose rate is also a signal is the integral of that rate's parabola.
"""

from fmus.cosimulation.polynomials import QUADRATIC
from fmus.cosimulation.scheme import Continuation, Scheme

COUPLING = Scheme(
    "jacobi_quadratic",
    "all subsystems at once, inputs extrapolated as parabolas",
    order=3,
    source="Busch, ZAMM 96 (2016) 1061-1081; angles from their rates: fmus/cosimulation/coupling/jacobi_quadratic.py",
    before=Continuation(QUADRATIC, angle=((0, 0), (0, 1), (-1, 1), (-2, 1))),
)
