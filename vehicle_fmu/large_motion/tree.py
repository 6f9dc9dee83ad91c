r"""A tree of rigid bodies in space: positions, Jacobians, mass matrix and inertia forces, for stacked motions.

A link k turns about (or slides along) its axis by q_k at the rate w_k, carried by its parent. With the joints P_k,
the axes a_k, the orientations R_k and the angular velocities omega_k, from parent to link:

    P_k = P + R (point_k - point) (+ a_k q_k of a slide),    a_k = R axis_k,    R_k = R rotation(axis_k, q_k)
    omega_k = omega + a_k w_k,    alpha_k = alpha + omega x a_k w_k               (without w_k')
    P_k'' = P'' + alpha x r + omega x (omega x r) (+ 2 omega x a_k w_k),    r = P_k - P

A point X of a link has the Jacobian a_j x (X - P_j) (a_j of a slide) for every link j on its path, its link the one a_j
(0 of a slide). With the mass centres' Jacobian J and the links' L, and b, alpha the accelerations for w' = 0:

    M = sum m J^T J + L^T I L,      h = sum m J^T b + L^T (I alpha + omega x I omega),      M w' + h = Q

Everything is an analytic function of q and w, so that derivatives by complex steps are exact (Squire, Trapp, SIAM
Review 40 (1998) 110-112). Leading axes of q and w stack motions.

Source: Kane, Levinson, Dynamics: Theory and Applications (1985); Featherstone, Rigid Body Dynamics Algorithms (2008).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Link:
    """A link of the tree: its name, that of its parent (empty: the ground), reference point and axis (3,), whether it
    slides.
    """

    name: str
    parent: str
    point: np.ndarray
    axis: np.ndarray
    slides: bool = False


@dataclass(frozen=True)
class RigidBody:
    """A body: the name of its link, mass [kg], mass centre (3,) [m], inertia (3, 3) [kg.m2] in axes of the frame."""

    link: str
    mass: float
    centre: np.ndarray
    inertia: np.ndarray


@dataclass(frozen=True)
class Motion:
    """Motion of all links (..., n, 3): orientation (..., n, 3, 3), joint, axis; angular velocity and joint's
    velocity; angular acceleration and joint's acceleration where no rate changes.
    """

    turned: np.ndarray
    joint: np.ndarray
    axis: np.ndarray
    omega: np.ndarray
    velocity: np.ndarray
    alpha: np.ndarray
    acceleration: np.ndarray

    def point(self, link: int, arm: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position, velocity and acceleration (..., 3) of a link's point at `arm` from its joint, in fixed axes."""
        spin = self.omega[..., link, :]
        turning = cross(spin, arm)
        return (
            self.joint[..., link, :] + arm,
            self.velocity[..., link, :] + turning,
            self.acceleration[..., link, :] + cross(self.alpha[..., link, :], arm) + cross(spin, turning),
        )


class Tree:
    """The links, parents before children, and the bodies that they carry."""

    def __init__(self, links: Sequence[Link], bodies: Sequence[RigidBody]):
        self.links = tuple(links)
        self.place = {link.name: k for k, link in enumerate(links)}
        self.parent = [self.place.get(link.parent, -1) for link in links]
        self.path = np.eye(len(links), dtype=bool)  # [k, j]: whether j is on the path of k
        for k, parent in enumerate(self.parent):
            if parent >= 0:
                self.path[k] |= self.path[parent]
        self.slides = np.array([link.slides for link in links])
        self.body_link = np.array([self.place[body.link] for body in bodies])
        self.mass = np.array([body.mass for body in bodies])
        self.inertia = np.array([body.inertia for body in bodies])
        self.arm = np.array([body.centre - self.links[k].point for body, k in zip(bodies, self.body_link, strict=True)])
        self.cross = np.array([_cross_matrix(link.axis) for link in links])
        self.cross_squared = self.cross @ self.cross

    def motion(self, q: np.ndarray, w: np.ndarray) -> Motion:
        """The motion of all links at coordinates and rates (..., n)."""
        shape, kind = q.shape[:-1], np.result_type(q, w)
        none = np.zeros((*shape, 3), kind)
        rows: list[tuple[np.ndarray, ...]] = []
        for k, link in enumerate(self.links):
            if self.parent[k] < 0:
                turned, joint, _, omega, velocity, alpha, acceleration = (
                    np.broadcast_to(np.eye(3, dtype=kind), (*shape, 3, 3)),
                    none,
                    none,
                    none,
                    none,
                    none,
                    none,
                )
                arm = link.point
            else:
                turned, joint, _, omega, velocity, alpha, acceleration = rows[self.parent[k]]
                arm = link.point - self.links[self.parent[k]].point
            axis, angle, rate = turned @ link.axis, q[..., k, None], w[..., k, None]
            away = turned @ arm + (axis * angle if link.slides else 0.0)
            turning, along = cross(omega, away), cross(omega, axis * rate)
            acceleration = acceleration + cross(alpha, away) + cross(omega, turning)
            velocity = velocity + turning
            if link.slides:
                rows.append(
                    (turned, joint + away, axis, omega, velocity + axis * rate, alpha, acceleration + 2 * along)
                )
            else:
                sine, versine = np.sin(angle)[..., None], 1 - np.cos(angle)[..., None]
                own = turned @ (np.eye(3) + sine * self.cross[k] + versine * self.cross_squared[k])
                rows.append((own, joint + away, axis, omega + axis * rate, velocity, alpha + along, acceleration))
        return Motion(*(np.stack(each, axis=-2 if i else -3) for i, each in enumerate(zip(*rows, strict=True))))

    def jacobians(self, motion: Motion, link: np.ndarray | int, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Jacobians (..., 3, n) of points (..., 3) of links, and of the links' rotation."""
        on_path = self.path[link][..., None]
        hinge = motion.axis if np.ndim(link) == 0 else motion.axis[..., None, :, :]
        joint = motion.joint if np.ndim(link) == 0 else motion.joint[..., None, :, :]
        turn = hinge * (on_path & ~self.slides[:, None])
        shift = cross(turn, point[..., None, :] - joint) + hinge * (on_path & self.slides[:, None])
        return shift.swapaxes(-1, -2), turn.swapaxes(-1, -2)

    def centres(self, motion: Motion) -> np.ndarray:
        """The mass centres (..., bodies, 3)."""
        return motion.joint[..., self.body_link, :] + self._arms(motion)

    def inertia_terms(self, motion: Motion) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Mass matrix M (..., n, n), inertia forces h (..., n), and forces (..., n) of the weights per gravity (z
        down).
        """
        k, arm = self.body_link, self._arms(motion)
        turned, omega, alpha = motion.turned[..., k, :, :], motion.omega[..., k, :], motion.alpha[..., k, :]
        shift, turn = self.jacobians(motion, k, motion.joint[..., k, :] + arm)
        tensor = turned @ self.inertia @ turned.swapaxes(-1, -2)
        bias = motion.acceleration[..., k, :] + cross(alpha, arm) + cross(omega, cross(omega, arm))
        moment = _apply(tensor, alpha) + cross(omega, _apply(tensor, omega))
        matrix = self.mass[:, None, None] * (shift.swapaxes(-1, -2) @ shift) + turn.swapaxes(-1, -2) @ tensor @ turn
        force = _apply(shift.swapaxes(-1, -2), self.mass[:, None] * bias) + _apply(turn.swapaxes(-1, -2), moment)
        return matrix.sum(axis=-3), force.sum(axis=-2), (self.mass[:, None] * shift[..., 2, :]).sum(axis=-2)

    def _arms(self, motion: Motion) -> np.ndarray:
        return _apply(motion.turned[..., self.body_link, :, :], self.arm)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The cross product (..., 3)."""
    return a.take(NEXT, -1) * b.take(AFTER, -1) - a.take(AFTER, -1) * b.take(NEXT, -1)


NEXT, AFTER = np.array([1, 2, 0]), np.array([2, 0, 1])


def _apply(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    return (matrix @ vector[..., None])[..., 0]


def _cross_matrix(axis: np.ndarray) -> np.ndarray:
    return np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
