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

import numpy as np

FRONT, LENGTHWISE, REAR = "front_suspension", "fork_lengthwise_bending", "rear_suspension"
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

    def __init__(self, values: Mapping[str, float]):
        def point(name: str) -> np.ndarray:
            return np.array([values[f"{name}_x"], values[f"{name}_z"]])

        top, pivot = point("rear_spring_top"), point("rocker_pivot")
        self.rod_joint, self.to_rod, self.to_spring = point("swingarm_rod"), point("rocker_rod"), point("rocker_spring")
        self.to_pivot, self.to_top = point("swingarm_axis") - pivot, top - pivot
        start = self.to_pivot + self.rod_joint
        self.rod = np.linalg.norm(start - self.to_rod)
        self.length = np.linalg.norm(self.to_spring - self.to_top)
        self.side = np.sign(_across(self.to_rod) @ start)

    def compression(self, angle: Any) -> tuple[Any, Any]:
        """s (...) [m] and ds / dq (...) [m/rad] at angles (...) of the swingarm [rad]; the wheel rises with them."""
        joint = _turned(self.rod_joint, np.cos(angle), np.sin(angle))
        w, b = joint + self.to_pivot, self.to_rod
        h = (b @ b + (w * w).sum(axis=-1) - self.rod**2) / 2
        P, Q = w @ b, w @ _across(b)
        t = (h - P) / (Q + self.side * np.sqrt(P**2 + Q**2 - h**2))
        cosine, sine = (1 - t**2) / (1 + t**2), 2 * t / (1 + t**2)
        rod_end, spring_end = (_turned(each, cosine, sine) for each in (b, self.to_spring))
        rod, spring = w - rod_end, spring_end - self.to_top
        length = np.sqrt((spring * spring).sum(axis=-1))
        ratio = (rod * _across(joint)).sum(axis=-1) / (rod * _across(rod_end)).sum(axis=-1)
        return self.length - length, -(spring * _across(spring_end)).sum(axis=-1) / length * ratio


def _turned(point: np.ndarray, cosine: Any, sine: Any) -> np.ndarray:
    """A point (2,) turned so that what lies behind the pivot rises (..., 2)."""
    return np.asarray(cosine)[..., None] * point + np.asarray(sine)[..., None] * _across(point)


def _across(vector: np.ndarray) -> np.ndarray:
    """Vectors (..., 2) turned by 90 deg: their derivative by the angle."""
    return np.stack([vector[..., 1], -vector[..., 0]], axis=-1)
