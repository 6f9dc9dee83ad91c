"""Polynomials over one step: interpolation of a signal at knots, and projection to the order that an FMU accepts.

    p(s) = c_0 + c_1 s + c_2 s^2 + c_3 s^3,   s = (time - t_n) / H in [0, 1]

A knot is (place, derivative): (0, 0) is the value at t_n, (-1, 0) the one a step before, (1, 1) the rate at
the end of the step. A signal's polynomial goes through as many knots as it has coefficients (Hermite-Birkhoff
interpolation). An FMU that takes inputs of a lower order gets the polynomial that is nearest in the mean
square: the error is then orthogonal to all polynomials of that order, so its effect on the states is of order
2 k + 3 in one step instead of k + 2.
"""

from functools import cache
from math import factorial, perm

import numpy as np
from numpy.polynomial import Legendre, Polynomial

Knot = tuple[int, int]
Knots = tuple[Knot, ...]

ORDER = 3  # the highest order that the FMUs of this project accept
COEFFICIENTS = ORDER + 1

HELD: Knots = ((0, 0),)
LINEAR: Knots = ((0, 0), (-1, 0))
QUADRATIC: Knots = ((0, 0), (-1, 0), (-2, 0))
END: Knots = ((1, 0),)
LINE: Knots = ((0, 0), (1, 0))
PARABOLA: Knots = ((-1, 0), (0, 0), (1, 0))
HERMITE: Knots = ((0, 0), (0, 1), (1, 0), (1, 1))
TAYLOR: Knots = ((0, 0), (0, 1), (0, 2), (0, 3))


@cache
def through(knots: Knots) -> np.ndarray:
    """Coefficients (4, knots) of the polynomial through the knots, per unit of each datum in normalised time."""
    powers = range(len(knots))
    rows = [[perm(k, d) * float(place) ** (k - d) if k >= d else 0.0 for k in powers] for place, d in knots]
    weights = np.zeros((COEFFICIENTS, len(knots)))
    weights[: len(knots)] = np.linalg.inv(np.array(rows))
    return weights


@cache
def nearest(order: int) -> np.ndarray:
    """The matrix (4, 4) from a polynomial to the nearest one of an order, in the mean square over the step."""
    return from_moments(order) @ np.array([[Legendre.basis(i, [0, 1]).convert(kind=Polynomial).coef @ moments(k, i)
                                            for k in range(COEFFICIENTS)] for i in range(COEFFICIENTS)])  # fmt: skip


def moments(power: int, order: int) -> np.ndarray:
    """The integrals of s^power s^j over the step for j = 0 .. order."""
    return 1.0 / (power + 1.0 + np.arange(order + 1))


@cache
def from_moments(order: int) -> np.ndarray:
    """Coefficients (4, 4) of the nearest polynomial of an order from a function's moments with Legendre's polynomials.

    Column i multiplies the integral of the function times P_i over the step; P_i are shifted to [0, 1].
    """
    matrix = np.zeros((COEFFICIENTS, COEFFICIENTS))
    for i in range(order + 1):
        coefficients = Legendre.basis(i, [0, 1]).convert(kind=Polynomial).coef
        matrix[: i + 1, i] = (2 * i + 1) * coefficients
    return matrix


def derivatives(coefficients: np.ndarray, step: float) -> np.ndarray:
    """Derivatives (4, ...) with respect to time at the start of the step."""
    factors = np.array([factorial(k) / step**k for k in range(len(coefficients))])
    return coefficients * factors.reshape(-1, *[1] * (coefficients.ndim - 1))
