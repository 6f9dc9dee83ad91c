r"""A torus on a flat road, and its tyre's wrench, in axes of the motorcycle's frame.

The formulas of `vehicle_fmu.large_motion.contact`, with the height z of A (down positive) and the road's direction down
D as given, and the slip as a result. With the wheel's centre W, the axle e, s = e.D = sin gamma, c = cos gamma:

    d = (D - s e) / c,    delta = z + W.D + (R - r_c) c + r_c,    X = W + (R - r_c) d + (r_c - delta) D
    t = e x D / c,    n = D x t,    delta' = X'.D
    kappa = Omega rho / (t.X') - 1,    rho = R_w - r_c + (r_c - delta) c,    alpha = -atan(n.X' / t.X')

The tyre's load F_0 + k delta + c delta' acts against D, its longitudinal force X_l along t and with -X_l rho on the
spin, its side force along n, its moment about D, at X on the wheel's carrier.

Source: as in `vehicle_fmu.large_motion.contact` and `vehicle_fmu.large_motion.tyre_forces`.
"""

from dataclasses import dataclass
from typing import Any

from vehicle_fmu.large_motion.frame_axes import Link, Twist, Vector, cross, dot, once, plus, times
from vehicle_fmu.large_motion.magic_formula import Tyre


@dataclass(frozen=True)
class WheelOnRoad:
    """Where a wheel touches the road: contact point, directions down, ahead and to the right, deflection [m] and its
    rate, rolling radius [m], longitudinal velocity [m/s], camber and slip angle [rad] and longitudinal slip.
    """

    point: Vector
    down: Vector
    ahead: Vector
    right: Vector
    deflection: Any
    sinking: Any
    radius: Any
    along: Any
    camber: Any
    slip: Any
    ratio: Any


@dataclass(frozen=True)
class TyreForce:
    """Load, longitudinal and side force [N], moment about the vertical [N.m], and their wrench on the carrier."""

    load: Any
    longitudinal: Any
    side: Any
    wrench: Twist


def wheel_on_road(
    carrier: Link, centre: Vector, down: Vector, depth: Any, spin: Any, height: Any, tube: Any, radius: Any, m: Any
) -> WheelOnRoad:
    """The contact of a wheel at `centre`, with the height of A as `depth` [m] and the spin [rad/s]; height, tube and
    radius are R, r_c and R_w [m].
    """
    axle = carrier.axes[1]
    s = m.term(dot(axle, down))
    c = m.term(m.sqrt(1 - s**2))
    to_rim = once(m, times(1 / c, plus(down, times(-s, axle))))
    deflection = m.term(depth + dot(centre, down) + (height - tube) * c + tube)
    point = once(m, plus(centre, times(height - tube, to_rim), times(tube - deflection, down)))
    velocity = once(m, carrier.twist.velocity(point))
    ahead = once(m, times(1 / c, cross(axle, down)))
    right = once(m, cross(down, ahead))
    along = m.term(dot(ahead, velocity))
    rolling = m.term(radius - tube + (tube - deflection) * c)
    slip, ratio = m.term(-m.atan(dot(right, velocity) / along)), m.term(spin * rolling / along - 1)
    sinking, camber = m.term(dot(velocity, down)), m.term(m.atan(s / c))
    return WheelOnRoad(point, down, ahead, right, deflection, sinking, rolling, along, camber, slip, ratio)


def tyre_force(wheel: WheelOnRoad, tyre: Tyre, load: Any, relaxed: Any) -> TyreForce:
    """The tyre's force at its load [N] and its relaxed slip angle [rad]."""
    m = tyre.m
    longitudinal = tyre.longitudinal_force(load, wheel.ratio, relaxed)
    side, moment = tyre.forces(load, relaxed, wheel.camber, wheel.ratio)
    force = once(m, plus(times(-load, wheel.down), times(longitudinal, wheel.ahead), times(side, wheel.right)))
    wrench = Twist(plus(cross(wheel.point, force), times(moment, wheel.down)), force).once(m)
    return TyreForce(load, longitudinal, side, wrench)
