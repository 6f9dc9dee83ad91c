"""Reduction of the full rider to the linear rider of the 2008 paper about a posture, and the inverse.

    [I_s   I_cc] q'' + [c_s + c_a       -c_a   ] q' + [k_s + k_a       -k_a   ] q = (M_s, 0)
    [I_cc  I_t ]       [  -c_a     c_t + c_a   ]      [  -k_a     k_t + k_a   ]

k_a = -K_12 couples bar and torso. The paper has k_s = c_s = 0: equal angles of bar and torso would not deflect the
arms. With two axes and a wide handlebar they do, so that k_s and c_s belong to the reduction. I_s is without the bar.

The inverse distributes a fitted rider (k_s = 0, k_a, k_t) over four joints: shoulders, elbows, wrists and waist. With
A_j the stiffness matrix of joint j at unit stiffness, sum k_j A_j + K_gravity = K is three equations in four unknowns
k_j >= 0, so that one direction is free. The reachable K are the cone of the A_j. A rider whose waist is soft compared
with the arms is outside the cone: bent arms with the coupling stiffness k_a add more than k_t to the torso (and a
negative k_s to the bar) without any waist. The result is then the nearest k_j, with the residual and the k_a, k_t, k_s
that they give.

Source: Cossalter, Doria, Fabris, Maso (2008), eqs 3, 4.
"""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.optimize import nnls

from fmus.declaration.component import Component
from fmus.equations.numpy_program import Program, recorded_equations
from fmus.expressions.functions import NUMERIC
from rider_fmu.components.full_rider import on_rig
from rider_fmu.components.passive_rider import PassiveRider
from rider_fmu.full_rider.limbs import motion

JOINTS = ("waist", "shoulder", "elbow", "wrist")
EXACT = 1e-9  # relative residual below which the values are met
_SLOPES: dict[Any, Program] = {}  # of the torques at rest by angles and rates, by the structure of the rig


@dataclass(frozen=True)
class Reduced:
    """Inertias [kg.m2], stiffnesses [N.m/rad] and dampings [N.m.s/rad] of the linear rider in one posture."""

    steer_inertia: float
    torso_inertia: float
    cross_inertia: float
    arm_stiffness: float
    waist_stiffness: float
    steer_stiffness: float
    arm_damping: float
    waist_damping: float
    steer_damping: float

    def passive_rider(self, name: str = "reduced") -> PassiveRider:
        """The linear rider of these values, without `steer_stiffness` and `steer_damping`, which it does not have."""
        return PassiveRider(name, torso_inertia=self.torso_inertia, cross_inertia=self.cross_inertia,
                            added_steer_inertia=self.steer_inertia, arm_stiffness=self.arm_stiffness,
                            waist_stiffness=self.waist_stiffness, arm_damping=self.arm_damping,
                            waist_damping=self.waist_damping)  # fmt: skip


def reduce(rider: Component, steer_angle: float = 0.0, torso_angle: float = 0.0) -> Reduced:
    """The linear rider about a posture [rad], from the exact Jacobian of Lagrange's equations."""
    still = motion(SimpleNamespace(**rider.values), NUMERIC, (steer_angle, torso_angle))
    K, C = matrices(rider, steer_angle, torso_angle)
    return Reduced(*(float(x) for x in (still.M11, still.M22, still.M12, -K[0, 1], K[1, 1] + K[0, 1], K[0, 0] + K[0, 1],
                                        -C[0, 1], C[1, 1] + C[0, 1], C[0, 0] + C[0, 1])))  # fmt: skip


def matrices(rider: Component, steer_angle: float = 0.0, torso_angle: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and damping matrices (2, 2) at rest in a posture [rad]."""
    rig = on_rig(rider)
    if rig.structure not in _SLOPES:
        torques = recorded_equations(rig).rates[2:]
        _SLOPES[rig.structure] = Program([torque.slope(x) for x in rig.states for torque in torques])
    values = {**rig.start_values(), "steer_angle": steer_angle, "torso_angle": torso_angle}
    stiffness, damping = -np.array(_SLOPES[rig.structure](values)).reshape(2, 2, 2).swapaxes(1, 2)
    return stiffness, damping


@dataclass(frozen=True)
class JointValues:
    """Joint values by name, the free direction of unit length in which they may change, and the residual.

    wanted and reached hold (k_a, k_t, k_s) or (c_a, c_t, c_s); residual is |sum k_j A_j - K| / |K| over the three
    entries.
    """

    joints: dict[str, float]
    free_direction: dict[str, float]
    wanted: tuple[float, float, float]
    reached: tuple[float, float, float]
    residual: float

    @property
    def at_zero(self) -> list[str]:
        """The joints whose value would have to be negative."""
        return [joint for joint, value in self.joints.items() if value <= 0] if self.residual > EXACT else []


def joint_values(rider: Component, linear: Component) -> dict[str, JointValues]:
    """The joint `stiffness` and `damping` that give the full rider the k_a, k_t, c_a, c_t of the linear one, and k_s
    = c_s = 0.
    """
    p = linear.values
    found = {}
    for kind, place in (("stiffness", 0), ("damping", 1)):
        free = {f"{joint}_{k}": 0.0 for joint in JOINTS for k in ("stiffness", "damping")}
        unit = [
            matrices(rider.with_values(**{**free, "gravity": 0.0, f"{joint}_{kind}": 1.0}))[place] for joint in JOINTS
        ]
        weight = matrices(rider.with_values(**free))[place]
        k_a, k_t = p[f"arm_{kind}"], p[f"waist_{kind}"]
        wanted = np.array([[k_a, -k_a], [-k_a, k_a + k_t]]) - weight
        columns = np.array([entries(A) for A in unit]).T
        solution = _middle(columns, entries(wanted))
        direction = np.linalg.svd(columns)[2][-1]
        missed = columns @ solution - entries(wanted)
        reached = (k_a - missed[1], k_t + missed[2] + missed[1], missed[0] + missed[1])
        residual = float(np.linalg.norm(missed) / np.linalg.norm(entries(wanted)))
        joints, free_direction = (dict(zip(JOINTS, values, strict=True)) for values in (solution, direction))
        found[kind] = JointValues(joints, free_direction, (k_a, k_t, 0.0), reached, residual)
    return found


def entries(matrix: np.ndarray) -> np.ndarray:
    """The three independent entries of a symmetric matrix (2, 2)."""
    return np.array([matrix[0, 0], matrix[0, 1], matrix[1, 1]])


def _middle(columns: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """The middle of the feasible interval along the free direction (all joints >= 0); without one the nearest point."""
    nearest = nnls(columns, wanted)[0]
    if np.linalg.norm(columns @ nearest - wanted) > EXACT * np.linalg.norm(wanted):
        return nearest
    direction = np.linalg.svd(columns)[2][-1]
    with np.errstate(divide="ignore"):
        limits = -nearest / direction
    low, high = max(limits[direction > 0], default=0.0), min(limits[direction < 0], default=0.0)
    return np.maximum(nearest + (low + high) / 2 * direction, 0.0)


def spread_over_joints(rider: Component, linear: Component) -> Component:
    """The full rider with the joint values of `joint_values`."""
    found = joint_values(rider, linear)
    return rider.with_values(
        **{f"{joint}_{kind}": value for kind, s in found.items() for joint, value in s.joints.items()}
    )
