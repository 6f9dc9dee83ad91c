"""Values with their exact first and second slopes in two variables q_1, q_2: second-order Taylor arithmetic.

    (f g)_ij = f_ij g + f_i g_j + f_j g_i + f g_ij,      h(f)_ij = h''(f) f_i f_j + h'(f) f_ij

With it the velocities and accelerations of a mechanism follow from the formula of its positions, on numbers and
on SymPy symbols alike. Source: Griewank, Walther, Evaluating Derivatives, 2nd ed. (2008), ch. 13.
"""

from collections.abc import Sequence
from typing import Any


class Jet:
    """A value f and its slopes f_1, f_2, f_11, f_12, f_22."""

    __array_ufunc__ = None  # an array times a jet is the jet's to work out, not one jet per element

    def __init__(self, f: Any, f1: Any = 0, f2: Any = 0, f11: Any = 0, f12: Any = 0, f22: Any = 0):
        self.f, self.f1, self.f2, self.f11, self.f12, self.f22 = f, f1, f2, f11, f12, f22

    @property
    def parts(self) -> tuple:
        return self.f, self.f1, self.f2, self.f11, self.f12, self.f22

    def __add__(self, other: Any) -> "Jet":
        if not isinstance(other, Jet):
            return Jet(self.f + other, *self.parts[1:])
        return Jet(*(a + b for a, b in zip(self.parts, other.parts, strict=True)))

    def __neg__(self) -> "Jet":
        return Jet(*(-a for a in self.parts))

    def __sub__(self, other: Any) -> "Jet":
        return self + (-other)

    def __rsub__(self, other: Any) -> "Jet":
        return -self + other

    def __mul__(self, other: Any) -> "Jet":
        if not isinstance(other, Jet):
            return Jet(*(a * other for a in self.parts))
        f, f1, f2, f11, f12, f22 = self.parts
        g, g1, g2, g11, g12, g22 = other.parts
        return Jet(f * g, f1 * g + f * g1, f2 * g + f * g2, f11 * g + 2 * f1 * g1 + f * g11,
                   f12 * g + f1 * g2 + f2 * g1 + f * g12, f22 * g + 2 * f2 * g2 + f * g22)  # fmt: skip

    __radd__, __rmul__ = __add__, __mul__

    def through(self, h: Any, slope: Any, curvature: Any) -> "Jet":
        """h(f), from the value, the slope and the curvature of the function h at f."""
        return Jet(h, slope * self.f1, slope * self.f2, curvature * self.f1 * self.f1 + slope * self.f11,
                   curvature * self.f1 * self.f2 + slope * self.f12, curvature * self.f2 * self.f2 + slope * self.f22)  # fmt: skip

    def sqrt(self, m: Any) -> "Jet":
        root = m.sqrt(self.f)
        return self.through(root, 1 / (2 * root), -1 / (4 * root * self.f))

    def reciprocal(self) -> "Jet":
        one = 1 / self.f
        return self.through(one, -one * one, 2 * one * one * one)

    def acos(self, m: Any) -> "Jet":
        height = 1 - self.f * self.f
        slope = -1 / m.sqrt(height)
        return self.through(m.acos(self.f), slope, slope * self.f / height)

    def term(self, m: Any, at: tuple) -> "Jet":
        """The same, each part computed once, with its slopes in the two variables `at` (see `fmus.terms`)."""
        f11, f12, f22 = (m.term(part) for part in self.parts[3:])
        f1, f2 = m.term(self.f1, at, (f11, f12)), m.term(self.f2, at, (f12, f22))
        return Jet(m.term(self.f, at, (f1, f2)), f1, f2, f11, f12, f22)


def rotation(angle: Any, variable: int, m: Any) -> tuple[Jet, Jet]:
    """Cosine and sine of an angle that is the first (1) or the second (2) variable."""
    c, s = m.cos(angle), m.sin(angle)
    if variable == 1:
        return Jet(c, f1=-s, f11=-c), Jet(s, f1=c, f11=-s)
    return Jet(c, f2=-s, f22=-c), Jet(s, f2=c, f22=-s)


def dot(a: Sequence, b: Sequence) -> Any:
    """Scalar product of two vectors of jets or of plain values."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
