"""Lagrange's equations of torso, arms and hands in the two angles that the closed arm loops leave.

With q = (steer angle, torso angle), positions r(q), and u the ABSOLUTE rates of the same two motions:

    M_ij = sum m r_i.r_j        T_i = sum m (r_ij u_j).(r_k u_k)
    b_i = sum m r_i.(r_jk q'_k u_j) + m (r_ij (q'_j - u_j)).(r_k u_k)
    M u' + b = Q
    R = M11 - kappa M12,  kappa = M12 / M22,     R' = 2 sum m (r_1 - kappa r_2).(r_1k - kappa r_2k) q'_k

b holds the centrifugal terms, T_i = dT/dq_i, Q the springs, dampers and weights. A rod of mass m between P and
P', its mass centre c from P, its transverse inertia J about it, has the kinetic energy

    (1/2) (A |P'|^2 + 2 B P'.P'' + C |P''|^2),  l = c/L:  A = m (1-l)^2 + J/L^2, B = m l (1-l) - J/L^2, C = m l^2 + J/L^2

in the velocities of its ends, so the elbow is all that has to be differentiated. The arms' inertia about their own
lengths (some g.m2) is left out.

Source: Cossalter, Doria, Fabris, Maso (2008), eqs 1, 2.
"""

from dataclasses import dataclass
from typing import Any

from fmus.jets import Jet, dot
from rider_fmu.arm_loop import Arm, Vector, arm, carried_by_bar, carried_by_torso, in_torso, minus, span

RATES = ("f1", "f2")
SECOND = {"f1": ("f11", "f12"), "f2": ("f12", "f22")}


@dataclass(frozen=True)
class Motion:
    """The terms of M u' + b = Q about the steer axis (1) and the waist axis (2), without the bare handlebar."""

    M11: Any
    M12: Any
    M22: Any
    b: tuple
    kinetic_slope: tuple
    Q: tuple
    reflected_slope: Any

    @property
    def ratio(self) -> Any:
        """kappa = M12 / M22."""
        return self.M12 / self.M22

    @property
    def reflected_inertia(self) -> Any:
        """The inertia M11 - M12^2 / M22 that is left at the steer axis when the torso is free."""
        return self.M11 - self.M12 * self.ratio


def motion(v: Any, m: Any, angles: tuple, rates: tuple = (0.0, 0.0), absolute: tuple | None = None) -> Motion:
    """The equations at angles (steer, torso) [rad], their rates, and the absolute ones where the frame turns [rad/s]."""
    sides = [_Side(v, m, arm(v, m, side, *angles), arm(v, m, side, 0.0, 0.0), angles) for side in (1, -1)]
    M11, M12, M22 = (m.term(sum(s.inertia(i, j) for s in sides)) for i, j in (("f1", "f1"), ("f1", "f2"), ("f2", "f2")))
    forces = [m.term(sum(s.force(i, rates) for s in sides)) for i in RATES]
    forces[1] = forces[1] - v.waist_stiffness * angles[1] - v.waist_damping * rates[1]
    turning = absolute if absolute is not None else rates
    centrifugal = tuple(m.term(sum(s.centrifugal(i, rates, turning) for s in sides)) for i in RATES)
    slopes_of_energy = tuple(m.term(sum(s.kinetic_slope(i, turning) for s in sides)) for i in RATES)
    ratio = M12 / (M22 + v.trunk_inertia)
    reflected_slope = 2 * m.term(sum(s.reflected_work(ratio, rates) for s in sides))
    return Motion(M11 + v.hands_inertia, M12, M22 + v.trunk_inertia, centrifugal, slopes_of_energy, tuple(forces), reflected_slope)


class _Side:
    """One arm: its rods, its joint springs, its weight."""

    def __init__(self, v: Any, m: Any, at: Arm, rest: Arm, angles: tuple):
        self.v, self.at = v, at
        self.points = (at.shoulder, at.elbow, at.wrist)
        upper = rod(v.upper_arm_mass, v.upper_arm_centre, v.upper_arm_inertia, v.upper_arm_length)
        fore = rod(v.forearm_mass, v.forearm_centre, v.forearm_inertia, v.forearm_length)
        self.weights = ((upper[0], upper[1], 0), (upper[1], upper[2] + fore[0], fore[1]), (0, fore[1], fore[2]))
        upper_rest, fore_rest = values(rest.upper), values(rest.fore)
        self.joints = (
            (v.elbow_stiffness, v.elbow_damping, (at.elbow_angle - rest.elbow_angle.f,)),
            (v.shoulder_stiffness, v.shoulder_damping, minus(at.upper, carried_by_torso(v, m, angles[1], in_torso(v, m, upper_rest)))),
            (v.wrist_stiffness, v.wrist_damping, minus(at.fore, carried_by_bar(m, angles[0], fore_rest))),
        )
        self.gravity = (-v.gravity * m.sin(v.steer_tilt), 0, v.gravity * m.cos(v.steer_tilt))

    def inertia(self, i: str, j: str) -> Any:
        return self._work(slopes(self.points, i), slopes(self.points, j))

    def centrifugal(self, i: str, rates: tuple, absolute: tuple) -> Any:
        first = slopes(self.points, "f11"), slopes(self.points, "f12"), slopes(self.points, "f22")
        (s, t), (a, b) = rates, absolute
        mixed = t * a + s * b
        bias = [tuple(s * a * f11 + mixed * f12 + t * b * f22 for f11, f12, f22 in zip(*parts, strict=True)) for parts in zip(*first, strict=True)]
        frame = s - a, t - b
        return self._work(slopes(self.points, i), bias) + self._work(self._combined(SECOND[i], frame), self._combined(RATES, absolute))

    def kinetic_slope(self, i: str, absolute: tuple) -> Any:
        return self._work(self._combined(SECOND[i], absolute), self._combined(RATES, absolute))

    def reflected_work(self, ratio: Any, rates: tuple) -> Any:
        """sum m Y.Y' of Y = r_1 - kappa r_2, the velocity that a unit steer rate gives when the torso is free."""
        kept = slopes(self.points, "f1"), slopes(self.points, "f2")
        changing = self._combined(SECOND["f1"], rates), self._combined(SECOND["f2"], rates)
        velocity, change = ([tuple(p - ratio * q for p, q in zip(a, b, strict=True)) for a, b in zip(*pair, strict=True)] for pair in (kept, changing))
        return self._work(velocity, change)

    def force(self, i: str, rates: tuple) -> Any:
        """The generalised force of joint springs and dampers and of the weight of the arm and hand."""
        total = 0
        for stiffness, damping, deflection in self.joints:
            for part in deflection:
                total = total - getattr(part, i) * (stiffness * part.f + damping * (part.f1 * rates[0] + part.f2 * rates[1]))
        v = self.v
        l, k = v.upper_arm_centre / v.upper_arm_length, v.forearm_centre / v.forearm_length
        masses = (v.upper_arm_mass * (1 - l), v.upper_arm_mass * l + v.forearm_mass * (1 - k), v.forearm_mass * k + v.hand_mass)
        return total + sum(mass * dot(self.gravity, p) for mass, p in zip(masses, slopes(self.points, i), strict=True))

    def _combined(self, parts: tuple[str, str], u: tuple) -> list[tuple]:
        one, two = (slopes(self.points, part) for part in parts)
        return [tuple(u[0] * p + u[1] * q for p, q in zip(a, b, strict=True)) for a, b in zip(one, two, strict=True)]

    def _work(self, left: list[tuple], right: list[tuple]) -> Any:
        """sum A_kl left_k.right_l over shoulder, elbow and wrist."""
        return sum(self.weights[k][l] * dot(left[k], right[l]) for k in range(3) for l in range(3) if abs(k - l) < 2)


def reach(v: Any, m: Any, side: int, steer_angle: Any, torso_angle: Any) -> tuple[Any, Any]:
    """Distance from shoulder to wrist [m], and the sine of the angle between that line and the wrist's axis."""
    D, h, _ = span(v, m, side, steer_angle, torso_angle)
    distance = m.sqrt(dot(D, D).f)
    return distance, m.sqrt(m.maximum(1 - (dot(D, h).f / distance) ** 2, 0.0))


def rod(mass: Any, centre: Any, inertia: Any, length: Any) -> tuple:
    """(A, B, C): the kinetic energy of a rod in the velocities of its ends."""
    l = centre / length
    spin = inertia / length**2
    return mass * (1 - l) ** 2 + spin, mass * l * (1 - l) - spin, mass * l**2 + spin


def slopes(points: tuple[Vector, ...], part: str) -> list[tuple]:
    """One kind of slope of every point."""
    return [tuple(getattr(component, part) for component in point) for point in points]


def values(vector: tuple[Jet, ...]) -> tuple:
    return tuple(component.f for component in vector)
