r"""The out-of-plane motion of a tree of rigid bodies about straight running at the speed V, linear.

Axes: x forward, y right, z down, moving with a point on the ground at V forward and v to the right, yawing at r. A body
moves by the freedoms of its path, from the ground to the body. A freedom j is a hinge about an axis u_j = (u_x, u_z)
through the point P_j, or a slide to the right. Lateral velocity v (a slide) and yaw rate r (a hinge about z) are the
first two; they have rates but no angles. With the rates w_k and the angles q_k, the point (x, z) of a body has

    to the right     y = sum Y_k q_k,    Y_k = u_kz (x - P_kx) - u_kx (z - P_kz),    Y_k = 1 of a slide
    tilt, heading    sum u_kx q_k,  sum u_kz q_k
    down, forward    of second order, with j nearer to the ground than k, and half of it for j = k:
                     u_jx Y_k q_j q_k,  - u_jz Y_k q_j q_k

and the equations of Lagrange in the moving axes (Boltzmann-Hamel), to first order, are for each freedom j

    sum_bodies [m Y_j (sum Y_k w_k' + V r) + u_j I sum u_k w_k' + h (u_jx u_kz - u_jz u_kx) w_k] = Q_j

I = [[I_x, -C], [-C, I_z]] with C the integral of x z dm, h = i_y V / R the spin momentum of a wheel. Forces act with

    side force F         Q_j = Y_j F
    moments (M_x, M_z)   Q_j = u_jx M_x + u_jz M_z
    weight or load F_z   Q_j = F_z (u_jx sum_{k >= j} Y_k q_k + Y_j sum_{k < j} u_kx q_k)
    force F_x            Q_j = -F_x (u_jz sum_{k >= j} Y_k q_k + Y_j sum_{k < j} u_kz q_k)
    F_x along a wheel    Q_j = -F_x (u_jz sum_{k >= j} Y_k q_k - Y_j sum_{k >= j} u_kz q_k)

A wheel's contact is the point of the wheel above its ground contact: the lowest point of a disc moves to the right and
up as this point does, to second order. Slip is the heading less (lateral velocity of the contact) / V, camber the tilt.

Source: linearisation of the rigid-body equations as in Sharp, J. Mech. Eng. Sci. 13(5) (1971), and Meijaard et al.,
Proc. R. Soc. A 463 (2007), Appendix; the tests derive the vehicles a second time with Kane's equations in full motion.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

Point = tuple[Any, Any]  # (x, z) [m]
LOCKED = 1e3  # 1/s: least decay of the states of a locked freedom, above all modes of vehicles


@dataclass(frozen=True, eq=False)
class Freedom:
    """A hinge about `axis` (u_x, u_z) through `point` (x, z), or a slide to the right where the axis is None.

    rate and angle are the names of the states; angle is empty for lateral velocity and yaw rate. free is 0 where the
    freedom is locked: it then moves no body, and its diagonal entry of the mass matrix is 1.
    """

    rate: str
    angle: str = ""
    axis: tuple[Any, Any] | None = None
    point: Point = (0, 0)
    free: Any = 1

    @property
    def tilt(self) -> Any:
        """u_x: tilt to the right per unit."""
        return self.axis[0] * self.free if self.axis else 0

    @property
    def heading(self) -> Any:
        """u_z: heading to the right per unit."""
        return self.axis[1] * self.free if self.axis else 0

    def shift(self, point: Point) -> Any:
        """Y: motion of the point (x, z) to the right per unit."""
        if self.axis is None:
            return self.free
        return self.heading * (point[0] - self.point[0]) - self.tilt * (point[1] - self.point[1])


LATERAL = Freedom("lateral_velocity")
YAW = Freedom("yaw_rate", axis=(0, 1))
ROLL = Freedom("roll_rate", "roll_angle", axis=(1, 0))
GROUND = (LATERAL, YAW, ROLL)

Path = tuple[Freedom, ...]


@dataclass(frozen=True)
class Body:
    """A rigid body: its path, mass [kg], mass centre (x, z) [m], roll and yaw inertia and the integral of x z dm about
    the mass centre [kg.m2], and the spin momentum of a wheel in it [N.m.s] or None.
    """

    path: Path
    mass: Any
    centre: Point
    roll_inertia: Any = 0
    yaw_inertia: Any = 0
    product: Any = 0
    spin: Any = None


def mass_matrix(bodies: Sequence[Body], freedoms: Sequence[Freedom]) -> dict[tuple[str, str], Any]:
    """The entries of the mass matrix by the names of two rates."""
    entries: dict[tuple[str, str], Any] = {}
    for a, j in enumerate(freedoms):
        for k in freedoms[a:]:
            entry = sum(_shared_inertia(body, j, k) for body in bodies if j in body.path and k in body.path)
            entries[j.rate, k.rate] = entries[k.rate, j.rate] = entry + (1 - j.free if j is k else 0)
    return entries


def held(j: Freedom, torque: Any, v: Any, place: int) -> Any:
    """The generalised force of the torque that holds a freedom; a locked freedom decays by itself at a and 2 a, with a
    that differs by its place among the freedoms, so that no eigenvalue is multiple.
    """
    a = LOCKED * (1 + place / 10)
    return -j.free * torque - (1 - j.free) * (2 * a**2 * v[j.angle] + 3 * a * v[j.rate])


def _shared_inertia(body: Body, j: Freedom, k: Freedom) -> Any:
    return (body.mass * j.shift(body.centre) * k.shift(body.centre)
            + j.tilt * body.roll_inertia * k.tilt + j.heading * body.yaw_inertia * k.heading
            - body.product * (j.tilt * k.heading + j.heading * k.tilt))  # fmt: skip


def inertia_force(j: Freedom, bodies: Iterable[Body], v: Any) -> Any:
    """The generalised force of turning (V r) and of the wheels' spin on the freedom j."""
    total = 0
    for body in bodies:
        if j not in body.path:
            continue
        total -= body.mass * j.shift(body.centre) * v.speed * v.yaw_rate
        if body.spin is not None:
            total -= body.spin * (j.tilt * turn_rate(body.path, v) - j.heading * tilt_rate(body.path, v))
    return total


def turn_rate(path: Path, v: Any) -> Any:
    """The rate about z of a body [rad/s]."""
    return sum(k.heading * v[k.rate] for k in path)


def tilt_rate(path: Path, v: Any) -> Any:
    """The rate about x of a body [rad/s]."""
    return sum(k.tilt * v[k.rate] for k in path)


def heading(path: Path, v: Any) -> Any:
    """The heading of a body relative to the moving axes [rad]."""
    return sum(k.heading * v[k.angle] for k in path if k.angle)


def tilt(path: Path, v: Any) -> Any:
    """The tilt of a body to the right: the camber of a wheel [rad]."""
    return sum(k.tilt * v[k.angle] for k in path if k.angle)


def lateral_velocity(path: Path, point: Point, v: Any) -> Any:
    """The velocity of a point of a body to the right [m/s]."""
    return sum(k.shift(point) * v[k.rate] for k in path)


def side_force(j: Freedom, path: Path, point: Point, force: Any, roll_moment: Any = 0, yaw_moment: Any = 0) -> Any:
    """The generalised force of a side force at a point of a body and of moments about x and z on it."""
    if j not in path:
        return 0
    return j.shift(point) * force + j.tilt * roll_moment + j.heading * yaw_moment


def vertical_force(j: Freedom, path: Path, point: Point, force: Any, v: Any) -> Any:
    """The generalised force of a vertical force (down positive) at a point of a body."""
    if j not in path:
        return 0
    above, below = _above_and_below(j, path)
    outer = sum(k.shift(point) * v[k.angle] for k in above)
    inner = sum(k.tilt * v[k.angle] for k in below)
    return force * (j.tilt * outer + j.shift(point) * inner)


def forward_force(j: Freedom, path: Path, point: Point, force: Any, v: Any, along_wheel: bool = False) -> Any:
    """The generalised force of a forward force at a point of a body, along the moving axes or along the body's heading.
    """
    if j not in path:
        return 0
    above, below = _above_and_below(j, path)
    outer = sum(k.shift(point) * v[k.angle] for k in above)
    turned = sum(k.heading * v[k.angle] for k in (above if along_wheel else below))
    return -force * (j.heading * outer + (-1 if along_wheel else 1) * j.shift(point) * turned)


def _above_and_below(j: Freedom, path: Path) -> tuple[list[Freedom], list[Freedom]]:
    """The freedoms of a path with an angle from j on, and those nearer to the ground."""
    place = path.index(j)
    return [k for k in path[place:] if k.angle], [k for k in path[:place] if k.angle]
