"""Second-order Taylor arithmetic: values with exact first and second derivatives in two variables q_1, q_2.

    (f g)_ij = f_ij g + f_i g_j + f_j g_i + f g_ij,      h(f)_ij = h''(f) f_i f_j + h'(f) f_ij

The velocities and accelerations of a mechanism follow in this way from the formula of its positions, on numbers and
on SymPy symbols. Source: Griewank, Walther, Evaluating Derivatives, 2nd ed. (2008), ch. 13.
"""

from collections.abc import Sequence
from typing import Any


class Taylor2:
    """A value f with its derivatives f_1, f_2, f_11, f_12, f_22."""

    __array_ufunc__ = None  # NumPy must leave array * Taylor2 to this class, instead of one product per element

    def __init__(self, f: Any, f1: Any = 0, f2: Any = 0, f11: Any = 0, f12: Any = 0, f22: Any = 0):
        self.f, self.f1, self.f2, self.f11, self.f12, self.f22 = f, f1, f2, f11, f12, f22

    @property
    def parts(self) -> tuple:
        """f, f_1, f_2, f_11, f_12, f_22."""
        return self.f, self.f1, self.f2, self.f11, self.f12, self.f22

    def __add__(self, other: Any) -> "Taylor2":
        if not isinstance(other, Taylor2):
            return Taylor2(self.f + other, *self.parts[1:])
        return Taylor2(*(a + b for a, b in zip(self.parts, other.parts, strict=True)))

    def __neg__(self) -> "Taylor2":
        return Taylor2(*(-a for a in self.parts))

    def __sub__(self, other: Any) -> "Taylor2":
        return self + (-other)

    def __rsub__(self, other: Any) -> "Taylor2":
        return -self + other

    def __mul__(self, other: Any) -> "Taylor2":
        if not isinstance(other, Taylor2):
            return Taylor2(*(a * other for a in self.parts))
        f, f1, f2, f11, f12, f22 = self.parts
        g, g1, g2, g11, g12, g22 = other.parts
        return Taylor2(f * g, f1 * g + f * g1, f2 * g + f * g2, f11 * g + 2 * f1 * g1 + f * g11,
                   f12 * g + f1 * g2 + f2 * g1 + f * g12, f22 * g + 2 * f2 * g2 + f * g22)  # fmt: skip

    __radd__, __rmul__ = __add__, __mul__

    def through(self, h: Any, slope: Any, curvature: Any) -> "Taylor2":
        """h(f) by the chain rule, from h, its first and its second derivative at f."""
        return Taylor2(h, slope * self.f1, slope * self.f2, curvature * self.f1 * self.f1 + slope * self.f11,
                   curvature * self.f1 * self.f2 + slope * self.f12,
                       curvature * self.f2 * self.f2 + slope * self.f22)  # fmt: skip

    def sqrt(self, m: Any) -> "Taylor2":
        """The square root; m has the functions."""
        root = m.sqrt(self.f)
        return self.through(root, 1 / (2 * root), -1 / (4 * root * self.f))

    def reciprocal(self) -> "Taylor2":
        """1 / f."""
        one = 1 / self.f
        return self.through(one, -one * one, 2 * one * one * one)

    def acos(self, m: Any) -> "Taylor2":
        """The arc cosine [rad]; m has the functions."""
        height = 1 - self.f * self.f
        slope = -1 / m.sqrt(height)
        return self.through(m.acos(self.f), slope, slope * self.f / height)

    def term(self, m: Any, at: tuple) -> "Taylor2":
        """The same value with each part as a shared term, whose derivatives in the two variables `at` are known."""
        f11, f12, f22 = (m.term(part) for part in self.parts[3:])
        f1, f2 = m.term(self.f1, at, (f11, f12)), m.term(self.f2, at, (f12, f22))
        return Taylor2(m.term(self.f, at, (f1, f2)), f1, f2, f11, f12, f22)


def rotation(angle: Any, variable: int, m: Any) -> tuple[Taylor2, Taylor2]:
    """Cosine and sine of an angle that is the first (1) or the second (2) variable."""
    c, s = m.cos(angle), m.sin(angle)
    if variable == 1:
        return Taylor2(c, f1=-s, f11=-c), Taylor2(s, f1=c, f11=-s)
    return Taylor2(c, f2=-s, f22=-c), Taylor2(s, f2=c, f22=-s)


def dot(a: Sequence, b: Sequence) -> Any:
    """Scalar product of two vectors with three components each."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
