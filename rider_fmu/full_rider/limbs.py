"""Lagrange's equations of torso, arms and hands in the two degrees of freedom, steer angle and torso angle.

With q = (steer angle, torso angle), positions r(q), and u the ABSOLUTE rates of the same two motions:

    M_ij = sum m r_i.r_j        G_ijk = sum m r_i.r_jk        dM_ij/dq_k = G_ijk + G_jik
    T_i = G_kij u_j u_k
    b_i = G_ijk q'_k u_j + G_kij (q'_j - u_j) u_k
    M u' + b = Q,               Q_i = F_i - D_ij q'_j
    R = M11 - kappa M12,  kappa = M12 / M22,     R' = 2 (G_11k - kappa (G_12k + G_21k) + kappa^2 G_22k) q'_k

b holds the centrifugal terms, T_i = dT/dq_i, F the springs and weights, D the dampers. M, G, F and D are functions of q
alone. A rod of mass m between P and P', its mass centre c from P, its
transverse inertia J about it, has the kinetic energy

    (1/2) (A |P'|^2 + 2 B P'.P'' + C |P''|^2),      l = c/L,
    A = m (1-l)^2 + J/L^2,   B = m l (1-l) - J/L^2,   C = m l^2 + J/L^2

in the velocities of its ends, so that only the elbow has to be differentiated. The inertia of the arms about their long
axes (some g.m2) is neglected.

Source: Cossalter, Doria, Fabris, Maso (2008), eqs 1, 2.
"""

from dataclasses import dataclass
from typing import Any

from fmus.expressions.taylor2 import Taylor2, dot
from rider_fmu.full_rider.arm_loop import Arm, Vector, arm, carried_by_bar, carried_by_torso, in_torso, minus, span

AXES = (0, 1)  # steer, waist
FIRST = ("f1", "f2")
SECOND = (("f11", "f12"), ("f12", "f22"))


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
    """The equations at the angles (steer, torso) [rad], their rates and, on a rotating frame, their absolute rates
    [rad/s].
    """
    both = m.total(
        (1, -1), lambda side: _Side(v, m, arm(v, m, side, *angles), arm(v, m, side, 0.0, 0.0), angles).coefficients()
    )
    G = [[[both["G", FIRST[i], SECOND[j][k]] for k in AXES] for j in AXES] for i in AXES]
    M = [[m.term(both["M", SECOND[i][j]], angles, [G[i][j][k] + G[j][i][k] for k in AXES]) for j in AXES] for i in AXES]
    F = [both["F", i] for i in FIRST]
    D = [[both["D", SECOND[i][j]] for j in AXES] for i in AXES]
    u = absolute if absolute is not None else rates
    frame = [rate - turning for rate, turning in zip(rates, u, strict=True)]
    slope_of_energy = tuple(sum(G[k][i][j] * u[j] * u[k] for j in AXES for k in AXES) for i in AXES)
    b = tuple(
        sum(G[i][j][k] * rates[k] * u[j] + G[k][i][j] * frame[j] * u[k] for j in AXES for k in AXES) for i in AXES
    )
    Q = [F[i] - sum(D[i][j] * rates[j] for j in AXES) for i in AXES]
    Q[1] = Q[1] - v.waist_stiffness * angles[1] - v.waist_damping * rates[1]
    M22 = M[1][1] + v.trunk_inertia
    ratio = m.term(M[0][1] / M22)
    reflected_slope = 2 * sum(
        (G[0][0][k] - ratio * (G[0][1][k] + G[1][0][k]) + ratio**2 * G[1][1][k]) * rates[k] for k in AXES
    )
    return Motion(M[0][0] + v.hands_inertia, M[0][1], M22, b, slope_of_energy, tuple(Q), reflected_slope)


class _Side:
    """One arm: rods, joint springs and weight."""

    def __init__(self, v: Any, m: Any, at: Arm, rest: Arm, angles: tuple):
        self.v, self.at = v, at
        self.points = (at.shoulder, at.elbow, at.wrist)
        upper = rod(v.upper_arm_mass, v.upper_arm_centre, v.upper_arm_inertia, v.upper_arm_length)
        fore = rod(v.forearm_mass, v.forearm_centre, v.forearm_inertia, v.forearm_length)
        self.weights = ((upper[0], upper[1], 0), (upper[1], upper[2] + fore[0], fore[1]), (0, fore[1], fore[2]))
        upper_rest, fore_rest = values(rest.upper), values(rest.fore)
        self.joints = (
            (v.elbow_stiffness, v.elbow_damping, (at.elbow_angle - rest.elbow_angle.f,)),
            (
                v.shoulder_stiffness,
                v.shoulder_damping,
                minus(at.upper, carried_by_torso(v, m, angles[1], in_torso(v, m, upper_rest))),
            ),
            (v.wrist_stiffness, v.wrist_damping, minus(at.fore, carried_by_bar(m, angles[0], fore_rest))),
        )
        self.gravity = (-v.gravity * m.sin(v.steer_tilt), 0, v.gravity * m.cos(v.steer_tilt))

    def coefficients(self) -> dict[tuple, Any]:
        """The contributions of this arm to M, G, F and D, by the derivatives that each belongs to."""
        pairs = {SECOND[i][j]: (FIRST[i], FIRST[j]) for i in AXES for j in AXES}
        return {
            **{("M", pair): self._work(i, j) for pair, (i, j) in pairs.items()},
            **{("G", i, pair): self._work(i, pair) for i in FIRST for pair in pairs},
            **{("F", i): self._force(i) for i in FIRST},
            **{("D", pair): self._damping(i, j) for pair, (i, j) in pairs.items()},
        }

    def _damping(self, i: str, j: str) -> Any:
        return sum(
            damping * getattr(part, i) * getattr(part, j)
            for _, damping, deflection in self.joints
            for part in deflection
        )

    def _force(self, i: str) -> Any:
        """The generalised force of the joint springs and of the weight of the arm and hand."""
        springs = sum(
            stiffness * getattr(part, i) * part.f for stiffness, _, deflection in self.joints for part in deflection
        )
        v = self.v
        l, k = v.upper_arm_centre / v.upper_arm_length, v.forearm_centre / v.forearm_length
        masses = (
            v.upper_arm_mass * (1 - l),
            v.upper_arm_mass * l + v.forearm_mass * (1 - k),
            v.forearm_mass * k + v.hand_mass,
        )
        return (
            sum(mass * dot(self.gravity, p) for mass, p in zip(masses, slopes(self.points, i), strict=True)) - springs
        )

    def _work(self, i: str, j: str) -> Any:
        """sum m r_i.r_j: A_kl r_i,k.r_j,l over shoulder, elbow and wrist."""
        left, right = slopes(self.points, i), slopes(self.points, j)
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
    """One derivative (`f1`, `f12`, ...) of every point."""
    return [tuple(getattr(component, part) for component in point) for point in points]


def values(vector: tuple[Taylor2, ...]) -> tuple:
    """The values of a vector, without derivatives."""
    return tuple(component.f for component in vector)
