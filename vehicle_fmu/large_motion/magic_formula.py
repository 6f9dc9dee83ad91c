r"""Motorcycle tyres by the Magic Formula at any side slip, longitudinal slip and camber.

With the load Z, the load increment d = (Z - Z_0) / Z_0, the slip angle alpha and the camber angle gamma:

    Y     = D sin(C_y atan(x - E (x - atan x)) + C_g atan(y - E_g (y - atan y))),    x = B alpha,   y = B_g gamma
    D     = Z p_Dy1 exp(p_Dy2 d) / (1 + p_Dy3 gamma^2),           E = p_Ey1 + p_Ey2 gamma^2 + p_Ey4 gamma sign(alpha)
    B     = K / (C_y D),      K = p_Ky1 Z_0 sin(p_Ky2 atan(Z / ((p_Ky3 + p_Ky4 gamma^2) Z_0))) / (1 + p_Ky5 gamma^2)
    B_g   = lambda (p_Ky6 + p_Ky7 d) Z / (C_g D)
    M_z   = -t Y(alpha, 0) + M_r
    t     = D_t cos(C_t atan(u - E_t (u - atan u))) / sqrt(1 + alpha^2),    u = B_t alpha
    B_t   = (q_Bz1 + q_Bz2 d) (1 + q_Bz5 |gamma| + q_Bz6 gamma^2)
    D_t   = Z (r_c / Z_0) (q_Dz1 + q_Dz2 d) (1 + q_Dz3 |gamma| + q_Dz4 gamma^2)
    E_t   = (q_Ez1 + q_Ez2 d) (1 + q_Ez5 gamma (2 / pi) atan(B_t C_t alpha))
    M_r   = Z r_c ((q_Dz8 + q_Dz9 d) gamma + (q_Dz10 + q_Dz11 d) gamma |gamma|)
            cos(atan((q_Bz9 + q_Bz10 B_0 C_y) (alpha + (q_Hz3 + q_Hz4 d) gamma))) / sqrt(1 + alpha^2)

B_0 is B at gamma = 0. Y has its greatest value D where the argument of the sine, the `use` of the grip, is pi / 2.
With the longitudinal slip kappa, positive when driven, the longitudinal force is

    X     = D_x sin(C_x atan(x - E_x (x - atan x))) cos(C_xa atan(B_xa alpha)),    x = B_x kappa
    D_x   = (p_Dx1 + p_Dx2 d) Z,     E_x = (p_Ex1 + p_Ex2 d + p_Ex3 d^2) (1 - p_Ex4 sign(kappa))
    B_x   = K_x / (C_x D_x),         K_x = Z (p_Kx1 + p_Kx2 d) exp(p_Kx3 d)
    B_xa  = r_Bx1 cos(atan(r_Bx2 kappa))

and in side force and moment (combined slip) Y has the factor cos(C_yk atan(B_yk kappa)), also where it makes the
moment, and the slip angle of t and M_r becomes its equivalent, squared a^2 + (kappa K_x / K_0)^2 (a: the slip angle
there), with B_yk = r_By1 cos(atan(r_By2 (|alpha| - r_By3))). The source has alpha there, by which left and right turns
would differ.

The derivatives at alpha = gamma = kappa = 0 are those of `vehicle_fmu.magic_formula_tyres`. The slip angle relaxes as
there, with the load and without the effect of camber on the relaxation length. Turn slip (the curvature of the path)
is left out.

Source: Pacejka, Tire and Vehicle Dynamics (2012), Section 4.3, motorcycle version; lambda and r_c as in the open
model of Passigato et al., Applied Sciences 10 (2020) 6826.
"""

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from fmus.expressions.functions import NUMERIC

NEARLY_ZERO = 1e-30  # rad2, below rounding: the root has a slope where both slips are 0
# Functions whose derivatives by complex steps are exact: the size of x is that of its real part's side.
ANALYTIC = SimpleNamespace(**{**vars(NUMERIC), "absolute": lambda x: np.where(np.real(x) < 0, -x, x)})
# The coefficients besides those of `vehicle_fmu.magic_formula_tyres`.
COEFFICIENTS = (
    "pDy1",
    "pDy2",
    "pDy3",
    "Cy",
    "pEy1",
    "pEy2",
    "pEy4",
    "pKy4",
    "pKy5",
    "Cga",
    "Ega",
    "Ct",
    "qBz1",
    "qBz2",
    "qBz5",
    "qBz6",
    "qBz9",
    "qBz10",
    "qDz3",
    "qDz4",
    "qDz10",
    "qDz11",
    "qEz1",
    "qEz2",
    "qEz5",
    "qHz3",
    "qHz4",
    "Cx",
    "pDx1",
    "pDx2",
    "pEx1",
    "pEx2",
    "pEx3",
    "pEx4",
    "pKx1",
    "pKx2",
    "pKx3",
    "rBx1",
    "rBx2",
    "Cxal",
    "rBy1",
    "rBy2",
    "rBy3",
    "Cyka",
)


class Tyre:
    """A tyre with its coefficients by name; m has the functions, of which the size is an analytic one by default."""

    def __init__(self, values: Mapping[str, Any], m: Any = ANALYTIC):
        self.values, self.m = dict(values), m

    def __getattr__(self, name: str) -> float:
        try:
            return self.__dict__["values"][name]
        except KeyError:
            raise AttributeError(name) from None

    def increment(self, load: Any) -> Any:
        """d: the load's difference from the nominal one, per nominal load."""
        return self.m.term((load - self.nominal_load) / self.nominal_load)

    def cornering_stiffness(self, load: Any, camber: Any = 0.0) -> Any:
        """K [N/rad] at a load [N] and a camber angle [rad]."""
        c = self
        share = load / ((c.pKy3 + c.pKy4 * camber**2) * c.nominal_load)
        return c.m.term(
            c.pKy1 * c.nominal_load * c.m.sin(c.pKy2 * c.m.atan(share)) / (1 + c.pKy5 * camber**2)
        )

    def relaxation_length(self, load: Any, speed: Any) -> Any:
        """sigma [m] at a load [N] and a speed [m/s]."""
        return self.cornering_stiffness(load) * (
            self.relaxation_0 + self.relaxation_1 * speed + self.relaxation_2 * speed**2
        )

    def use(self, load: Any, slip: Any, camber: Any) -> tuple[Any, Any, Any]:
        """The greatest side force D [N], the argument of the sine in Y [rad], and B [1/rad]."""
        c = self
        greatest = c.m.term(load * c.pDy1 * c.m.exp(c.pDy2 * self.increment(load)) / (1 + c.pDy3 * camber**2))
        B = c.m.term(self.cornering_stiffness(load, camber) / (c.Cy * greatest))
        x = c.m.term(B * slip)
        y = c.m.term(c.camber_scale * (c.pKy6 + c.pKy7 * self.increment(load)) * load / (c.Cga * greatest) * camber)
        by_slip = self._bent(x, c.pEy1 + c.pEy2 * camber**2, c.pEy4 * camber)
        return greatest, c.m.term(c.Cy * c.m.atan(by_slip) + c.Cga * c.m.atan(self._bent(y, c.Ega))), B

    def longitudinal_stiffness(self, load: Any) -> Any:
        """K_x [N] at a load [N]."""
        c, d = self, self.increment(load)
        return c.m.term(load * (c.pKx1 + c.pKx2 * d) * c.m.exp(c.pKx3 * d))

    def longitudinal_use(self, load: Any, ratio: Any) -> tuple[Any, Any]:
        """The greatest longitudinal force D_x [N] and the argument of the sine in X [rad] at a longitudinal slip."""
        c, d = self, self.increment(load)
        greatest = c.m.term((c.pDx1 + c.pDx2 * d) * load)
        E = c.m.term(c.pEx1 + c.pEx2 * d + c.pEx3 * d**2)
        x = c.m.term(self.longitudinal_stiffness(load) / (c.Cx * greatest) * ratio)
        return greatest, c.m.term(c.Cx * c.m.atan(self._bent(x, E, -E * c.pEx4)))

    def longitudinal_force(self, load: Any, ratio: Any, slip: Any) -> Any:
        """X [N] at a load [N], a longitudinal slip and a relaxed slip angle [rad]."""
        greatest, argument = self.longitudinal_use(load, ratio)
        m, by_slip = self.m, self.rBx1 / self.m.sqrt(1 + (self.rBx2 * ratio) ** 2)
        return m.term(greatest * m.sin(argument) * m.cos(self.Cxal * m.atan(by_slip * slip)))

    def forces(self, load: Any, slip: Any, camber: Any, ratio: Any = None) -> tuple[Any, Any]:
        """Side force Y [N] and moment about z [N.m] at a load [N], relaxed slip and camber angle [rad], and with a
        longitudinal slip unless that is None.
        """
        c, m, d = self, self.m, self.increment(load)
        by_ratio, left = (0.0, 1.0) if ratio is None else self._combined(load, slip, ratio)
        greatest, argument, _ = self.use(load, slip, camber)
        upright, only_slip, B = self.use(load, slip, 0.0 * camber)
        size = m.absolute(camber)
        Bt = m.term((c.qBz1 + c.qBz2 * d) * (1 + c.qBz5 * size + c.qBz6 * camber**2))
        Dt = load * c.section_radius / c.nominal_load * (c.qDz1 + c.qDz2 * d) * (1 + c.qDz3 * size + c.qDz4 * camber**2)
        Et = m.term((c.qEz1 + c.qEz2 * d) * (1 + c.qEz5 * camber * (2 / m.pi) * m.atan(Bt * c.Ct * slip)))
        equivalent = m.term(Bt * m.sqrt(slip**2 + by_ratio**2 + NEARLY_ZERO))
        trail = m.term(Dt * m.cos(c.Ct * m.atan(self._bent(equivalent, Et))) / m.sqrt(1 + slip**2))
        residual = load * c.section_radius * ((c.qDz8 + c.qDz9 * d) * camber + (c.qDz10 + c.qDz11 * d) * camber * size)
        shifted = m.term((slip + (c.qHz3 + c.qHz4 * d) * camber) ** 2 + by_ratio**2)
        residual = residual / m.sqrt((1 + (c.qBz9 + c.qBz10 * B * c.Cy) ** 2 * shifted) * (1 + slip**2))
        return m.term(left * greatest * m.sin(argument)), m.term(-trail * left * upright * m.sin(only_slip) + residual)

    def _combined(self, load: Any, slip: Any, ratio: Any) -> tuple[Any, Any]:
        """kappa K_x / K_0, and the factor of the side force."""
        m = self.m
        shared = self.rBy1 / m.sqrt(1 + (self.rBy2 * (m.absolute(slip) - self.rBy3)) ** 2)
        by_ratio = m.term(self.longitudinal_stiffness(load) / self.cornering_stiffness(load) * ratio)
        return by_ratio, m.term(m.cos(self.Cyka * m.atan(shared * ratio)))

    def _bent(self, x: Any, E: Any, by_side: Any = 0.0) -> Any:
        """x - (E + by_side sign(x)) (x - atan x)."""
        bend = self.m.term(x - self.m.atan(x))
        return self.m.term(x - E * bend - by_side * self.m.absolute(bend))
