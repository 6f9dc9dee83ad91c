"""One arm between torso and handlebar: a closed kinematic loop of two rods, solved in closed form.

The shoulder S moves with the torso (spherical joint), the wrist W with the handlebar; the elbow E between them is a
revolute joint, upper arm a, forearm b. The hand is fixed to the grip. The wrist's two revolutes are one about
an axis h that is fixed in the hand and one parallel to the elbow's, so the plane of the arm contains h. With

    D = W - S,  sigma = |D|^2,  eta = D.h,  x = (sigma + a^2 - b^2) / (2 sigma),
    z = sqrt((a^2/sigma - x^2) / (sigma - eta^2)):        E = S + (x - z eta) D + z sigma h

which is the solution on the side of h. The angles of bar and torso are the only degrees of freedom.

Axes: fixed to the steer axis, origin at the steering head, x forward, y right, z down along the axis. The waist
axis goes from the head down to the pelvis, at the angle `steer_tilt` + `torso_inclination` to the steer axis.

Source: Cossalter, Doria, Fabris, Maso, Measurement and identification of the vibration characteristics of
motorcycle riders (2008), Fig. 8: spherical shoulder, revolute elbow, wrist of two revolutes.
"""

from dataclasses import dataclass
from typing import Any

from fmus.expressions.taylor2 import Taylor2, dot, rotation

Vector = tuple[Taylor2, Taylor2, Taylor2]


@dataclass(frozen=True)
class Arm:
    """Positions [m] of shoulder, elbow and wrist, with derivatives in (steer angle, torso angle), and the elbow angle.

    upper and fore are unit vectors along the limbs; elbow_angle [rad] is pi for a straight arm.
    """

    shoulder: Vector
    elbow: Vector
    wrist: Vector
    upper: Vector
    fore: Vector
    elbow_angle: Taylor2


def arm(v: Any, m: Any, side: int, steer_angle: Any, torso_angle: Any) -> Arm:
    """The arm on one side (1 right, -1 left) at a steer angle and a torso angle [rad]; lengths in m."""
    at = (steer_angle, torso_angle)
    D, h, shoulder = span(v, m, side, *at)
    a, b = v.upper_arm_length, v.forearm_length
    sigma, eta = dot(D, D).term(m, at), dot(D, h).term(m, at)
    inverse = sigma.reciprocal().term(m, at)
    x = (inverse * (a * a - b * b) + 1) * 0.5
    z = (
        ((inverse * (a * a) - x * x).term(m, at) * (sigma - eta * eta).term(m, at).reciprocal())
        .term(m, at)
        .sqrt(m)
        .term(m, at)
    )
    along, beside = (x - z * eta).term(m, at), (z * sigma).term(m, at)
    wrist = plus(shoulder, D)
    from_shoulder = tuple((along * D[i] + beside * h[i]).term(m, at) for i in range(3))
    elbow = once(plus(shoulder, from_shoulder), m, at)
    upper = tuple(p * (1 / a) for p in from_shoulder)
    fore = tuple(p * (1 / b) for p in minus(wrist, elbow))
    return Arm(shoulder, elbow, wrist, upper, fore, ((a * a + b * b - sigma) * (1 / (2 * a * b))).acos(m).term(m, at))


def span(v: Any, m: Any, side: int, steer_angle: Any, torso_angle: Any) -> tuple[Vector, Vector, Vector]:
    """(D, h, S): shoulder to wrist, the wrist's axis in the hand, and the shoulder."""
    out, aside = side * v.grip_half_width, side * m.sin(v.elbow_spread)
    wrist = carried_by_bar(m, steer_angle, (-v.grip_setback, out, -v.grip_rise))
    h = carried_by_bar(m, steer_angle, (0, aside, m.cos(v.elbow_spread)))
    shoulder = plus(
        pelvis(v, m), carried_by_torso(v, m, torso_angle, (0, side * v.shoulder_half_width, -v.torso_length))
    )
    return once(minus(wrist, shoulder), m, (steer_angle, torso_angle)), h, shoulder


def pelvis(v: Any, m: Any) -> tuple:
    """The point of the waist axis at the pelvis [m]."""
    c, s = m.cos(v.steer_tilt), m.sin(v.steer_tilt)
    drop = v.saddle_drop - v.hip_rise
    return (-v.saddle_distance * c - drop * s, 0, drop * c - v.saddle_distance * s)


def carried_by_torso(v: Any, m: Any, torso_angle: Any, point: tuple) -> Vector:
    """A vector fixed in the torso (x forward, y right, z down the waist axis), in the steer axes at the torso angle."""
    c, s = rotation(torso_angle, 2, m)
    x, y = point[0] * c - point[1] * s, point[0] * s + point[1] * c
    tilt = v.steer_tilt + v.torso_inclination
    return (x * m.cos(tilt) - point[2] * m.sin(tilt), y, x * m.sin(tilt) + point[2] * m.cos(tilt))


def in_torso(v: Any, m: Any, vector: tuple) -> tuple:
    """A vector of the steer axes in those of the torso at rest."""
    tilt = v.steer_tilt + v.torso_inclination
    return (
        vector[0] * m.cos(tilt) + vector[2] * m.sin(tilt),
        vector[1],
        vector[2] * m.cos(tilt) - vector[0] * m.sin(tilt),
    )


def carried_by_bar(m: Any, steer_angle: Any, point: tuple) -> Vector:
    """A vector fixed in the handlebar, in the steer axes at the steer angle."""
    c, s = rotation(steer_angle, 1, m)
    return (point[0] * c - point[1] * s, point[0] * s + point[1] * c, Taylor2(point[2]))


def once(a: tuple, m: Any, at: tuple) -> tuple:
    """The vector with its components as shared terms; `at` are the two angles."""
    return tuple(p.term(m, at) for p in a)


def plus(a: tuple, b: tuple) -> tuple:
    """The sum of two vectors."""
    return tuple(p + q for p, q in zip(a, b, strict=True))


def minus(a: tuple, b: tuple) -> tuple:
    """The difference of two vectors."""
    return tuple(p - q for p, q in zip(a, b, strict=True))
