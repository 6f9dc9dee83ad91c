"""Jacobi with every input continued along the parabola through the last three values. Order 3.

An angle whose rate is a signal too is the integral of that rate's parabola.
"""

from fmus.coupling.polynomials import QUADRATIC
from fmus.coupling.scheme import Continuation, Scheme

JACOBI_QUADRATIC = Scheme(
    "jacobi_quadratic",
    "all units at once, inputs continued as parabolas",
    order=3,
    stable=(0.01055, 0.00835),
    source="Busch, ZAMM 96 (2016) 1061-1081; angles from their rates: fmus/coupling/jacobi_quadratic.py",
    before=Continuation(QUADRATIC, angle=((0, 0), (0, 1), (-1, 1), (-2, 1))),
)
