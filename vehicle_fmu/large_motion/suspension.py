r"""Freedoms in the motorcycle's plane: suspensions at both ends and bending of the fork lengthwise, with preloads.

A coordinate q is positive where the wheel's load deflects it, 0 at standstill on level ground. It shortens its spring
by s(q), and with preload F_0, stiffness k and damping c its generalised force is

    Q = -(F_0 + k s + c s_q q') s_q,    s_q = ds / dq

Front suspension (the lower fork slides along the fork) and lengthwise bending (a hinge at the fork's joint): s = q.

Rear suspension: the swingarm turns by q about its pivot A in the frame. A rod of constant length joins its point
A + R(q) a to the point B + R(theta) b of a rocker, which turns about B in the frame and whose point B + R(theta) d
compresses the spring against T in the frame. With w = A + R(q) a - B, b' = b turned by 90 deg, and t = tan(theta / 2):

    R(theta) b.w = h,    h = (b.b + w.w - rod^2) / 2,    P = b.w,    Q = b'.w
    t = (h - P) / (Q + sign(Q_0) sqrt(P^2 + Q^2 - h^2)),    s = |B + d - T| - |B + R(theta) d - T|

theta' follows from the rod: it has no velocity along itself. Rod and rocker have no mass.

Source: values and linkage of the open model of Passigato et al., Applied Sciences 10 (2020) 6826. Its dampers differ in
compression and rebound; c is the mean of both slopes, the first harmonic of such a damper's force (describing function;
Gelb, Vander Velde (1968)).
"""

from collections.abc import Mapping
from typing import Any

from fmus.expressions.functions import NUMERIC

FRONT, LENGTHWISE, REAR = "front_suspension", "fork_lengthwise_bending", "rear_suspension"
Point = tuple[Any, Any]
SUSPENSIONS = (FRONT, LENGTHWISE, REAR)
COEFFICIENTS = ("stiffness", "damping", "preload")
POINTS = ("rear_spring_top", "rocker_pivot", "rocker_rod", "rocker_spring", "swingarm_rod")
SUPPLEMENT = (
    *SUSPENSIONS,
    *(f"{name}_{what}" for name in SUSPENSIONS for what in COEFFICIENTS),
    *(f"{point}_{axis}" for point in POINTS for axis in "xz"),
)


class RearLinkage:
    """The spring's compression over the swingarm's angle; points (x, z) with z up, from the reference point of the
    frame, of the rocker from its pivot, and of the rod's joint from the swingarm's pivot.
    """

    def __init__(self, values: Mapping[str, Any], m: Any = NUMERIC):
        def point(name: str) -> Point:
            return values[f"{name}_x"], values[f"{name}_z"]

        self.m = m
        top, pivot = point("rear_spring_top"), point("rocker_pivot")
        self.rod_joint, self.to_rod, self.to_spring = point("swingarm_rod"), point("rocker_rod"), point("rocker_spring")
        self.to_pivot, self.to_top = _less(point("swingarm_axis"), pivot), _less(top, pivot)
        start = _plus(self.to_pivot, self.rod_joint)
        self.rod, self.length = self._size(_less(start, self.to_rod)), self._size(_less(self.to_spring, self.to_top))
        self.side = m.sign(_dot(_across(self.to_rod), start))

    def compression(self, angle: Any) -> tuple[Any, Any]:
        """s (...) [m] and ds / dq (...) [m/rad] at angles (...) of the swingarm [rad]; the wheel rises with them."""
        m, b = self.m, self.to_rod
        joint = _turned(self.rod_joint, m.cos(angle), m.sin(angle))
        w = _plus(joint, self.to_pivot)
        h = m.term((_dot(b, b) + _dot(w, w) - self.rod**2) / 2)
        P, Q = m.term(_dot(w, b)), m.term(_dot(w, _across(b)))
        t = m.term((h - P) / (Q + self.side * m.sqrt(P**2 + Q**2 - h**2)))
        cosine, sine = m.term((1 - t**2) / (1 + t**2)), m.term(2 * t / (1 + t**2))
        rod_end, spring_end = (_turned(each, cosine, sine) for each in (b, self.to_spring))
        rod, spring = _less(w, rod_end), _less(spring_end, self.to_top)
        length = m.term(self._size(spring))
        ratio = _dot(rod, _across(joint)) / _dot(rod, _across(rod_end))
        return self.length - length, -_dot(spring, _across(spring_end)) / length * ratio

    def _size(self, vector: Point) -> Any:
        return self.m.sqrt(_dot(vector, vector))


def _turned(point: Point, cosine: Any, sine: Any) -> Point:
    """A point turned so that what lies behind the pivot rises."""
    across = _across(point)
    return cosine * point[0] + sine * across[0], cosine * point[1] + sine * across[1]


def _across(vector: Point) -> Point:
    """A vector turned by 90 deg: its derivative by the angle."""
    return vector[1], -vector[0]


def _plus(a: Point, b: Point) -> Point:
    return a[0] + b[0], a[1] + b[1]


def _less(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1]


def _dot(a: Point, b: Point) -> Any:
    return a[0] * b[0] + a[1] * b[1]
