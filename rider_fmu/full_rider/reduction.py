"""The full rider linearised about a posture, as equations (3), (4) of the 2008 paper, and the way back.

    [I_s   I_cc] q'' + [c_s + c_a       -c_a   ] q' + [k_s + k_a       -k_a   ] q = (M_s, 0)
    [I_cc  I_t ]       [  -c_a     c_t + c_a   ]      [  -k_a     k_t + k_a   ]

k_a = -K_12 couples bar and torso. The paper has k_s = c_s = 0: turning bar and torso by one angle would not deflect
an arm. With two axes and wide handlebars it does, so k_s and c_s belong to the reduction. I_s is without the bar.

The way back spreads a fitted rider (k_s = 0, k_a, k_t) over four joints: shoulders, elbows, wrists and waist. With
A_j the stiffness matrix of joint j at unit stiffness, sum k_j A_j + K_gravity = K is three equations in four
unknowns, k_j >= 0: one free direction. What four springs can make is the cone of their A_j. A rider is outside it
whose waist is soft beside his arms: bent arms that hold bar and torso together with k_a stiffen the torso by more than
his k_t (and the bar by less than nothing, k_s < 0) before a waist is added. Then the nearest k_j are given, with their
residual and the k_a, k_t, k_s that they make.

Source: Cossalter, Doria, Fabris, Maso (2008), eqs 3, 4.
"""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from scipy.optimize import nnls

from fmus.component import Component
from fmus.mathematics import NUMERIC
from fmus.symbolic import symbolic
from rider_fmu.full_rider import on_rig
from rider_fmu.limbs import motion
from rider_fmu.passive_rider import PassiveRider

JOINTS = ("waist", "shoulder", "elbow", "wrist")
EXACT = 1e-9  # relative, of what is asked for


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
        """The linear rider of these values; what it has no parameters for are `steer_stiffness` and `steer_damping`."""
        return PassiveRider(name, torso_inertia=self.torso_inertia, arm_stiffness=self.arm_stiffness, waist_stiffness=self.waist_stiffness,
                            arm_damping=self.arm_damping, waist_damping=self.waist_damping, cross_inertia=self.cross_inertia,
                            added_steer_inertia=self.steer_inertia)  # fmt: skip


def reduce(rider: Component, steer_angle: float = 0.0, torso_angle: float = 0.0) -> Reduced:
    """The linear rider about a posture [rad], from the exact Jacobian of Lagrange's equations."""
    still = motion(SimpleNamespace(**rider.values), NUMERIC, (steer_angle, torso_angle))
    K, C = matrices(rider, steer_angle, torso_angle)
    return Reduced(*(float(x) for x in (still.M11, still.M22, still.M12, -K[0, 1], K[1, 1] + K[0, 1], K[0, 0] + K[0, 1],
                                        -C[0, 1], C[1, 1] + C[0, 1], C[0, 0] + C[0, 1])))  # fmt: skip


def matrices(rider: Component, steer_angle: float = 0.0, torso_angle: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and damping matrices (2, 2) about a posture: minus the slopes of the forces at rest there."""
    rig = on_rig(rider)
    form = symbolic(rig)
    values = {**rig.start_values(), "steer_angle": steer_angle, "torso_angle": torso_angle, **{s.name: 0.0 for s in form.derivative_symbols}}
    jacobian = form.jacobian_entries(values)
    return -jacobian[2:4, 0:2], -jacobian[2:4, 2:4]


@dataclass(frozen=True)
class Spread:
    """Joint values by name, the free direction in which they may move (unit length), and what no joint could meet.

    wanted and reached hold (k_a, k_t, k_s) or (c_a, c_t, c_s); residual is |sum k_j A_j - K| / |K| over the three entries.
    """

    joints: dict[str, float]
    free_direction: dict[str, float]
    wanted: tuple[float, float, float]
    reached: tuple[float, float, float]
    residual: float

    @property
    def at_zero(self) -> list[str]:
        """The joints that would have to be less than nothing."""
        return [joint for joint, value in self.joints.items() if value <= 0] if self.residual > EXACT else []


def spread(rider: Component, linear: Component) -> dict[str, Spread]:
    """Joint `stiffness` and `damping` with which the full rider has the linear rider's k_a, k_t, c_a, c_t and no k_s, c_s."""
    p = linear.values
    found = {}
    for kind, place in (("stiffness", 0), ("damping", 1)):
        free = {f"{joint}_{k}": 0.0 for joint in JOINTS for k in ("stiffness", "damping")}
        unit = [matrices(rider.with_values(**{**free, "gravity": 0.0, f"{joint}_{kind}": 1.0}))[place] for joint in JOINTS]
        weight = matrices(rider.with_values(**free))[place]
        k_a, k_t = p[f"arm_{kind}"], p[f"waist_{kind}"]
        wanted = np.array([[k_a, -k_a], [-k_a, k_a + k_t]]) - weight
        columns = np.array([entries(A) for A in unit]).T
        solution = _middle(columns, entries(wanted))
        direction = np.linalg.svd(columns)[2][-1]
        missed = columns @ solution - entries(wanted)
        reached = (k_a - missed[1], k_t + missed[2] + missed[1], missed[0] + missed[1])
        found[kind] = Spread(dict(zip(JOINTS, solution, strict=True)), dict(zip(JOINTS, direction, strict=True)), (k_a, k_t, 0.0), reached,
                             float(np.linalg.norm(missed) / np.linalg.norm(entries(wanted))))  # fmt: skip
    return found


def entries(matrix: np.ndarray) -> np.ndarray:
    """The three different entries of a symmetric matrix."""
    return np.array([matrix[0, 0], matrix[0, 1], matrix[1, 1]])


def _middle(columns: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """The middle of the stretch of the free direction that keeps all joints at zero or above; else the nearest point."""
    nearest = nnls(columns, wanted)[0]
    if np.linalg.norm(columns @ nearest - wanted) > EXACT * np.linalg.norm(wanted):
        return nearest
    direction = np.linalg.svd(columns)[2][-1]
    with np.errstate(divide="ignore"):
        limits = -nearest / direction
    low, high = max(limits[direction > 0], default=0.0), min(limits[direction < 0], default=0.0)
    return np.maximum(nearest + (low + high) / 2 * direction, 0.0)


def spread_over_joints(rider: Component, linear: Component) -> Component:
    """The full rider with the joint values of `spread`."""
    found = spread(rider, linear)
    return rider.with_values(**{f"{joint}_{kind}": value for kind, s in found.items() for joint, value in s.joints.items()})
