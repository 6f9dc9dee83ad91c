r"""A torus on a flat road: its contact, its depth in the road, and the rate of its longitudinal slip.

A wheel has the axle e, a rim circle of radius R - r_c and a round cross-section of radius r_c (R: height of its centre
upright). With down D, s = e.D = sin gamma and c = cos gamma, the undeflected tyre is deepest in the road at

    centre + (R - r_c) d + r_c D,    d = (D - s e) / c;    its depth is the deflection delta
    contact        X = centre + (R - r_c) d + (r_c - delta) D
    heading        t = e x D / c,    right n = D x t
    depth          delta' = X'.D
    rolling        (1 + kappa) t.X' = Omega rho,    rho = R_w - r_c + (r_c - delta) c

X' is the velocity of the wheel's carrier at X, Omega the spin relative to the carrier, R_w the wheel's radius, kappa
the longitudinal slip. A load acts along the row of -delta', a longitudinal force along the row of t.X' - Omega rho.
Both conditions are rows C w of the rates; their derivatives C w' + g need, without w',

    e' = omega x e,    e'' = alpha x e + omega x e',    c' = -s s' / c,    c'' = -s'^2 / c^3 - s s'' / c
    d' = (-s' e - s e' - c' d) / c,    t' = e' x D / c - t c' / c

Source: torus on a plane as in Lot, Meccanica 39 (2004) 481-496; deflection across the road and slip as in the open
model of Passigato et al., Applied Sciences 10 (2020) 6826.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from vehicle_fmu.large_motion.tree import Motion, Tree, cross

DOWN = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Wheel:
    """A wheel: the links of its carrier and of its spin, and R, r_c and R_w [m]."""

    carrier: int
    spin: int
    height: float
    section_radius: float
    radius: float


@dataclass(frozen=True)
class Contact:
    """Where a wheel touches the road, for stacked motions.

    point, heading `ahead` and `right` (..., 3), camber [rad] and deflection [m] (...); Jacobians (..., 3, n) `shift` of
    the point and `turn` of the carrier; velocities (...) of the carrier there along and across the heading; the rows
    (..., n) of -delta' (`rises`), of t.X' - Omega rho (`slides`) and of (1 + kappa) t.X' - Omega rho (`rolls`), and
    what the derivatives of the first and the last have where no rate changes (...).
    """

    point: np.ndarray
    ahead: np.ndarray
    right: np.ndarray
    camber: np.ndarray
    deflection: np.ndarray
    shift: np.ndarray
    turn: np.ndarray
    along: np.ndarray
    across: np.ndarray
    rises: np.ndarray
    slides: np.ndarray
    rolls: np.ndarray
    rise_bias: np.ndarray
    roll_bias: np.ndarray


def contact(wheel: Wheel, tree: Tree, motion: Motion, ratio: Any = 0.0) -> Contact:
    """The contact of a wheel in a motion of its tree, with the longitudinal slip `ratio` (...)."""
    spin, carrier, tube = wheel.spin, wheel.carrier, wheel.section_radius
    rim, axle = wheel.height - tube, motion.turned[..., carrier, :, 1]
    omega, alpha = motion.omega[..., carrier, :], motion.alpha[..., carrier, :]
    s = axle[..., 2:]
    c = np.sqrt(1 - s**2)
    axle_rate = cross(omega, axle)
    axle_bias = cross(alpha, axle) + cross(omega, axle_rate)
    s_rate, c_rate = axle_rate[..., 2:], -s * axle_rate[..., 2:] / c
    c_bias = -(s_rate**2) / c**3 - s * axle_bias[..., 2:] / c
    to_rim = (DOWN - s * axle) / c
    to_rim_rate = (-s_rate * axle - s * axle_rate - to_rim * c_rate) / c
    to_centre = motion.joint[..., spin, :] - motion.joint[..., carrier, :]
    deepest, _, _ = motion.point(carrier, to_centre + rim * to_rim + tube * DOWN)
    depth = deepest[..., 2:]
    arm = rim * to_rim + (tube - depth) * DOWN
    point, velocity, _ = motion.point(carrier, to_centre + arm)
    _, _, centre_bias = motion.point(carrier, to_centre)
    depth_rate = velocity[..., 2:]
    ahead = cross(axle, DOWN) / c
    ahead_rate = cross(axle_rate, DOWN) / c - ahead * c_rate / c
    right = cross(DOWN, ahead)
    shift, turn = tree.jacobians(motion, carrier, point)
    heading = (ahead[..., None, :] @ shift)[..., 0, :]
    circumference = np.zeros_like(heading)
    circumference[..., spin] = (wheel.radius - tube + (tube - depth) * c)[..., 0]
    spin_rate = -dot(motion.omega[..., spin, :] - omega, axle)
    bias = centre_bias + cross(alpha, arm) + cross(omega, rim * to_rim_rate - depth_rate * DOWN)
    radius_rate = ((tube - depth) * c_rate - depth_rate * c)[..., 0]
    return Contact(
        point, ahead, right, np.arctan(s / c)[..., 0], depth[..., 0], shift, turn,
        dot(ahead, velocity), dot(right, velocity),
        rises=-shift[..., 2, :],
        slides=heading - circumference,
        rolls=(1 + np.asarray(ratio)[..., None]) * heading - circumference,
        rise_bias=-(centre_bias[..., 2] + rim * c_bias[..., 0]),
        roll_bias=(1 + ratio) * (dot(ahead_rate, velocity) + dot(ahead, bias)) - spin_rate * radius_rate,
    )  # fmt: skip


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The scalar product (...) of vectors (..., 3)."""
    return (a * b).sum(axis=-1)
