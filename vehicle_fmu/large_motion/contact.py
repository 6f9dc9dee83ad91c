r"""A rolling torus on a flat road: its contact, and the conditions that it stays on the road and rolls.

A wheel has the axle e, a rim circle of radius R - r_c and a round cross-section of radius r_c (R: height of its centre
upright). With down D, s = e.D = sin gamma and c = cos gamma:

    contact        X = centre + (R - r_c) d + r_c D,    d = (D - s e) / c
    heading        t = e x D / c,    right n = D x t
    on the road    X.D = 0
    rolling        t.X' = Omega rho,    rho = R_w - r_c + r_c c

X' is the velocity of the wheel's carrier at X, Omega the spin relative to the carrier, R_w the wheel's radius. Both
conditions are rows of the rates, G w = 0, and their derivatives are G w' + g = 0, where g needs, without w',

    e' = omega x e,    e'' = alpha x e + omega x e',    c' = -s s' / c,    c'' = -s'^2 / c^3 - s s'' / c
    d' = (-s' e - s e' - c' d) / c,    t' = e' x D / c - t c' / c

Source: torus on a plane as in Lot, Meccanica 39 (2004) 481-496.
"""

from dataclasses import dataclass

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

    point, heading `ahead` and `right` (..., 3), camber [rad] (...); Jacobians (..., 3, n) `shift` of the point and
    `turn` of the carrier; velocities (...) of the carrier there along and across the heading; the rows (..., n) of the
    conditions (`rises`: velocity out of the road; `rolls`) and what their derivatives have where no rate changes (...).
    """

    point: np.ndarray
    ahead: np.ndarray
    right: np.ndarray
    camber: np.ndarray
    shift: np.ndarray
    turn: np.ndarray
    along: np.ndarray
    across: np.ndarray
    rises: np.ndarray
    rolls: np.ndarray
    rise_bias: np.ndarray
    roll_bias: np.ndarray


def contact(wheel: Wheel, tree: Tree, motion: Motion) -> Contact:
    """The contact of a wheel in a motion of its tree."""
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
    arm = rim * to_rim + tube * DOWN
    point, velocity, _ = motion.point(carrier, to_centre + arm)
    _, _, centre_bias = motion.point(carrier, to_centre)
    ahead = cross(axle, DOWN) / c
    ahead_rate = cross(axle_rate, DOWN) / c - ahead * c_rate / c
    right = cross(DOWN, ahead)
    shift, turn = tree.jacobians(motion, carrier, point)
    rolls = (ahead[..., None, :] @ shift)[..., 0, :]
    rolls[..., spin] -= (wheel.radius - tube + tube * c)[..., 0]
    spin_rate = -dot(motion.omega[..., spin, :] - omega, axle)
    bias = centre_bias + cross(alpha, arm) + cross(omega, rim * to_rim_rate)
    return Contact(
        point, ahead, right, np.arctan(s / c)[..., 0], shift, turn, dot(ahead, velocity), dot(right, velocity),
        rises=-shift[..., 2, :], rolls=rolls, rise_bias=-(centre_bias[..., 2] + rim * c_bias[..., 0]),
        roll_bias=dot(ahead_rate, velocity) + dot(ahead, bias) - spin_rate * tube * c_rate[..., 0],
    )  # fmt: skip


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The scalar product (...) of vectors (..., 3)."""
    return (a * b).sum(axis=-1)
