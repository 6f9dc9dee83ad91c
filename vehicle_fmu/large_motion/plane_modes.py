r"""Names of the modes in the motorcycle's plane, upright: bounce, pitch, hop of either wheel, bending of the fork.

Upright, motion in the plane and out of it do not act on each other to first order. A mode in the plane is named by
where its kinetic energy is: with the velocities v of the mass centres in the mode, of the sprung bodies (all but lower
fork, swingarm and wheels) the part M |V_z|^2 of their common mass centre (bounce) and what they have about it (pitch);
of the unsprung bodies at each end the vertical part m |v_z|^2 (front_hop, rear_hop), and in front the part along the
road (fork_bending). Names are given to the modes so that the sum of these shares is largest (linear sum assignment),
each name where its freedoms exist. Shares count with the participation of deflections in the mode, which modes of
speed and of longitudinal slip lack, and half for a real root, of which a pair has two.

Source: names as in Cossalter, Motorcycle Dynamics (2006), Chapter 5.
"""

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np

from vehicle_fmu.large_motion.equations import LargeMotion
from vehicle_fmu.large_motion.suspension import FRONT, LENGTHWISE, REAR
from vehicle_fmu.large_motion.touring_tree import ORDER, PLANE

UNSPRUNG = {"front": ("lower_fork", "front_wheel"), "rear": ("swingarm", "rear_wheel")}


def in_plane(states: Sequence[str]) -> np.ndarray:
    """Which states (nx,) belong to the motion in the plane, upright."""
    return np.array(
        [n == "forward_speed" or n.removesuffix("_rate").removesuffix("_position") in PLANE for n in states]
    )


def plane_modes(
    motion: LargeMotion, matrix: np.ndarray, found: SimpleNamespace, states: Sequence[str]
) -> dict[str, complex]:
    """The eigenvalue, with Im >= 0, of each mode in the plane by name, from the matrix (nx, nx) of the given first
    states of a motorcycle about an upright equilibrium.
    """
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415 - imported on use: it takes 0.5 s

    if not (names := _names(motion)):
        return {}
    own = np.flatnonzero(in_plane(states)).tolist()
    values, shapes = np.linalg.eig(matrix[np.ix_(own, own)])
    kept = np.flatnonzero(values.imag >= 0)
    shares = np.array(
        [_shares(motion, found, {states[k]: x for k, x in zip(own, shapes[:, j], strict=True)}) for j in kept]
    )
    participation = np.abs(shapes * np.linalg.inv(shapes).T)[:, kept]
    deflects = np.array([states[k].endswith(("_rate", "_position")) for k in own])
    weight = participation[deflects].sum(axis=0) / participation.sum(axis=0) * np.where(values[kept].imag > 0, 1.0, 0.5)
    score = (shares * weight[:, None])[:, [SHARES.index(name) for name in names]]
    named = {
        names[name]: complex(values[kept[mode]]) for mode, name in zip(*linear_sum_assignment(-score), strict=True)
    }
    return {name: named[name] for name in names}


SHARES = ("bounce", "pitch", "front_hop", "rear_hop", "fork_bending")


def _names(motion: LargeMotion) -> list[str]:
    """The modes that the free freedoms have."""
    front, rear = ((s in motion.free, bool(f)) for s, f in zip((FRONT, REAR), motion.condition_free[:2], strict=True))
    there = {
        "bounce": any(front) and any(rear),
        "pitch": any(front) or any(rear),
        "front_hop": all(front),
        "rear_hop": all(rear),
        "fork_bending": LENGTHWISE in motion.free,
    }
    return [name for name, found in there.items() if found]


def _shares(motion: LargeMotion, found: SimpleNamespace, shape: dict[str, complex]) -> np.ndarray:
    """The shares (5,) of the kinetic energy of a mode in the plane, in the order of SHARES."""
    w = np.zeros(len(motion.tree.links), complex)
    w[motion.place["along"]] = shape.get("forward_speed", 0.0)
    for name in motion.free:
        w[motion.place[name]] = shape.get(f"{name}_rate", 0.0)
    sinking = [shape.get(f"{end}_tyre_deflection_rate", 0.0) for end in UNSPRUNG]
    rows, pair = found.rows[:2], motion.dependent[:2]
    w[pair] = np.linalg.solve(rows[:, pair], -np.array(sinking) - rows @ w)
    centres = motion.tree.centres(found.motion)
    shift, turn = motion.tree.jacobians(found.motion, motion.tree.body_link, centres)
    v, mass = shift @ w, motion.tree.mass
    front, rear = (np.isin(ORDER, names) for names in UNSPRUNG.values())
    sprung = ~(front | rear)
    whole = mass[sprung].sum()
    common = mass[sprung] @ v[sprung] / whole
    vertical, along = mass * np.abs(v[:, 2]) ** 2, mass * np.abs(v[:, 0]) ** 2
    turning = (turn[:, 1] @ w)[sprung]
    about = vertical[sprung].sum() + along[sprung].sum() - whole * (np.abs(common) ** 2).sum()
    about += motion.tree.inertia[sprung, 1, 1] @ np.abs(turning) ** 2
    bounce = whole * abs(common[2]) ** 2
    energy = np.array([bounce, about, vertical[front].sum(), vertical[rear].sum(), along[front].sum()])
    return energy / (w.conj() @ motion.tree.inertia_terms(found.motion)[0] @ w).real
